#include "bound/screen_kernels.hpp"
#include "lanes/compiled_set.hpp"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Values of forms in float, and those of them that lie in given bands. With AVX-512 the values in a band are
// compressed by one instruction; elsewhere they are looked for one by one.

namespace qerr::lanes {
namespace {

struct FloatsOf {
  typedef float type __attribute__((vector_size(sizeof(CompiledLanes))));
};
using Floats = FloatsOf::type;
constexpr std::size_t float_lanes = sizeof(Floats) / sizeof(float);
/// Forms and vectors whose sums are held in registers: 16 of 32 with AVX-512, 8 of 16 elsewhere.
constexpr std::size_t forms_at_once = 4;
constexpr std::size_t vectors_at_once = float_lanes == 16 ? 4 : 2;

[[gnu::always_inline]] inline Floats load_floats(const float* from) {
  Floats f;
  __builtin_memcpy(&f, from, sizeof f);
  return f;
}

/// Sums of some forms at some vectors of a block.
template <class Use>
[[gnu::always_inline]] inline void sums(const float* block, std::size_t count, const float* weights,
                                        std::size_t first, Use use) {
  Floats sum[forms_at_once][vectors_at_once] = {};
  for (std::size_t k = 0; k < count; ++k) {
    Floats column[vectors_at_once];
    for (std::size_t v = 0; v < vectors_at_once; ++v)
      column[v] = load_floats(block + k * batch_size + first + v * float_lanes);
    for (std::size_t f = 0; f < forms_at_once; ++f) {
      const Floats weight = weights[f * count + k] - Floats{};
      for (std::size_t v = 0; v < vectors_at_once; ++v) sum[f][v] = weight * column[v] + sum[f][v];
    }
  }
  for (std::size_t f = 0; f < forms_at_once; ++f)
    for (std::size_t v = 0; v < vectors_at_once; ++v) use(f, first + v * float_lanes, sum[f][v]);
}

void values(const float* columns, std::size_t blocks, std::size_t count, const float* weights, float* to) {
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t g = 0; g < forms_per_tile; g += forms_at_once)
      for (std::size_t first = 0; first < batch_size; first += vectors_at_once * float_lanes)
        sums(columns + b * count * batch_size, count, weights + g * count, first,
             [&](std::size_t f, std::size_t at, const Floats& sum) {
               __builtin_memcpy(to + ((g + f) * blocks + b) * batch_size + at, &sum, sizeof sum);
             });
}

/// @param at  place of the first value
[[gnu::always_inline]] inline void keep(const Floats& x, std::int32_t at, bool only_top, ScreenBand& band) {
#if defined(__AVX512F__)
  const __m512 value = reinterpret_cast<__m512>(x);
  const __mmask16 above = _mm512_cmp_ps_mask(value, _mm512_set1_ps(band.lower), _CMP_GE_OQ);
  __mmask16 within = above;
  if (!only_top) {
    band.below +=
        static_cast<std::uint32_t>(float_lanes) - static_cast<std::uint32_t>(__builtin_popcount(above));
    within = _mm512_mask_cmp_ps_mask(above, value, _mm512_set1_ps(band.upper), _CMP_LT_OQ);
  }
  if (within == 0) return;
  const __m512i places = _mm512_add_epi32(
      _mm512_set1_epi32(at), _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
  if (band.count <= band.most) {
    _mm512_storeu_ps(band.values + band.count, _mm512_maskz_compress_ps(within, value));
    _mm512_storeu_si512(band.at + band.count, _mm512_maskz_compress_epi32(within, places));
  }
  band.count += static_cast<std::uint32_t>(__builtin_popcount(within));
#else
  // Bit i: lane i is at least the lower limit; is in the band.
  unsigned above = 0, within;
#if defined(__AVX2__)
  const auto value = reinterpret_cast<__m256>(x);
  above =
      static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(value, _mm256_set1_ps(band.lower), _CMP_GE_OQ)));
  within = above;
  if (!only_top)
    within &= static_cast<unsigned>(
        _mm256_movemask_ps(_mm256_cmp_ps(value, _mm256_set1_ps(band.upper), _CMP_LT_OQ)));
#else
  for (std::size_t i = 0; i < float_lanes; ++i) above |= static_cast<unsigned>(x[i] >= band.lower) << i;
  within = above;
  for (std::size_t i = 0; i < float_lanes && !only_top; ++i)
    within &= ~(static_cast<unsigned>(x[i] >= band.upper) << i);
#endif
  if (!only_top)
    band.below +=
        static_cast<std::uint32_t>(float_lanes) - static_cast<std::uint32_t>(__builtin_popcount(above));
  for (; within != 0; within &= within - 1) {
    const int i = __builtin_ctz(within);
    if (band.count <= band.most) {
      band.values[band.count] = x[i];
      band.at[band.count] = at + i;
    }
    ++band.count;
  }
#endif
}

template <bool only_top>
void screen_bands(const float* columns, std::size_t blocks, std::size_t count, const float* weights,
                  ScreenBand* bands, std::size_t bands_per_form) {
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t g = 0; g < forms_per_tile; g += forms_at_once)
      for (std::size_t first = 0; first < batch_size; first += vectors_at_once * float_lanes)
        sums(columns + b * count * batch_size, count, weights + g * count, first,
             [&](std::size_t f, std::size_t at, const Floats& sum) {
               const auto place = static_cast<std::int32_t>(b * batch_size + at);
               ScreenBand* const own = bands + (g + f) * bands_per_form;
               if constexpr (only_top) {
                 keep(sum, place, true, *own);
               } else {
                 for (std::size_t i = 0; i < bands_per_form; ++i) keep(sum, place, false, own[i]);
               }
             });
}

void screen(const float* columns, std::size_t blocks, std::size_t count, const float* weights,
            ScreenBand* bands, std::size_t bands_per_form) {
  bool only_top = bands_per_form == 1;
  for (std::size_t f = 0; f < forms_per_tile && only_top; ++f) only_top = bands[f].upper == __builtin_inff();
  if (only_top)
    screen_bands<true>(columns, blocks, count, weights, bands, bands_per_form);
  else
    screen_bands<false>(columns, blocks, count, weights, bands, bands_per_form);
}

/// A comparison's lanes: -1 where it holds.
using FloatBits = decltype(Floats{} < Floats{});

std::uint32_t below(const float* values, std::uint32_t count, float x) {
  FloatBits sum = {};
  const Floats limit = x - Floats{};
  std::uint32_t i = 0;
  for (; i + float_lanes <= count; i += float_lanes) sum -= load_floats(values + i) < limit;
  std::uint32_t total = 0;
  for (std::size_t lane = 0; lane < float_lanes; ++lane) total += static_cast<std::uint32_t>(sum[lane]);
  for (; i < count; ++i) total += values[i] < x;
  return total;
}

std::uint32_t within(const float* values, const std::int32_t* at, std::uint32_t count, float lower,
                     float upper, std::int32_t* to) {
  std::uint32_t found = 0, i = 0;
#if defined(__AVX512F__)
  for (; i + float_lanes <= count; i += float_lanes) {
    const __m512 value = _mm512_loadu_ps(values + i);
    const __mmask16 some =
        _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(value, _mm512_set1_ps(lower), _CMP_GE_OQ), value,
                                _mm512_set1_ps(upper), _CMP_LE_OQ);
    if (some == 0) continue;
    _mm512_storeu_si512(to + found, _mm512_maskz_compress_epi32(some, _mm512_loadu_si512(at + i)));
    found += static_cast<std::uint32_t>(__builtin_popcount(some));
  }
#endif
  for (; i < count; ++i)
    if (values[i] >= lower && values[i] <= upper) to[found++] = at[i];
  return found;
}

void root_sums(const double* const* columns, std::size_t count, const double* weights, double added,
               std::size_t configurations, double* partial) {
  using L = CompiledLanes;
  for (std::size_t i = 0; i < batch_size; ++i) partial[i] = 0;
  for (std::size_t at = 0; at < configurations; at += lane_count<L>) {
    L sum = broadcast<L>(added);
    for (std::size_t k = 0; k < count; ++k) {
      const L column = load<L>(columns[k] + at);
      sum = fma(column * column, weights[k], sum);
    }
    const std::size_t place = at % batch_size;
    store(partial + place, load<L>(partial + place) + sqrt(sum));
  }
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const ScreenKernels& compiled_kernels<ScreenKernels, lanes::compiled_set>() {
  static constexpr ScreenKernels kernels{lanes::values, lanes::screen, lanes::below, lanes::within,
                                         lanes::root_sums};
  return kernels;
}

}  // namespace qerr
