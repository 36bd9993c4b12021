#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "bound/kernels.hpp"
#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"

namespace qerr::lanes {
namespace {

/// Maximum of a batch.
template <class L>
[[gnu::always_inline]] inline double largest(const double* values) {
  L high = load<L>(values);
  for (std::size_t i = lane_count<L>; i < batch_size; i += lane_count<L>)
    high = max(load<L>(values + i), high);
  double most = high[0];
#pragma GCC unroll 8
  for (std::size_t i = 1; i < lane_count<L>; ++i) most = high[i] > most ? high[i] : most;
  return most;
}

/// Updates the maxima of a batch in which at least one is new, and their configurations.
template <class L>
[[gnu::noinline]] void find_maxima(const double* figures, std::size_t count, std::uint64_t first,
                                   Tally* tallies) {
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    const double most = largest<L>(values);
    if (!(most > t.max)) continue;
    const bool is_larger = most > same_maximum * t.max;
    t.max = most;
    for (std::size_t i = 0; i < batch_size && is_larger; ++i)
      if (values[i] * same_maximum >= most) {
        t.at_max = first + i;
        break;
      }
  }
}

/// A vector of bins, twice as many as doubles.
template <class L>
struct BinsOf {
  typedef std::int32_t type __attribute__((vector_size(sizeof(L))));
  static constexpr std::size_t count = 2 * lane_count<L>;
};
template <class L>
using Bins = typename BinsOf<L>::type;

/// Bins of two vectors of values, from the upper halves of the doubles.
template <class L>
[[gnu::always_inline]] inline Bins<L> bins_of(const double* values) {
  constexpr int u = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? 1 : 0;
  const auto a = __builtin_bit_cast(Bins<L>, load<L>(values)),
             b = __builtin_bit_cast(Bins<L>, load<L>(values + lane_count<L>));
  Bins<L> upper;
  if constexpr (lane_count<L> == 8)
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6, u + 8, u + 10, u + 12, u + 14, u + 16,
                                    u + 18, u + 20, u + 22, u + 24, u + 26, u + 28, u + 30);
  else if constexpr (lane_count<L> == 4)
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6, u + 8, u + 10, u + 12, u + 14);
  else
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6);
  return upper >> (bin_shift - 32);
}

#if defined(__AVX2__)
/// [mask]: indices of the set bits of an 8-bit mask, a byte each.
constexpr struct KeptIndices {
  std::uint64_t of[256] = {};

  constexpr KeptIndices() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      int shift = 0;
      for (std::uint64_t bit = 0; bit < 8; ++bit)
        if (mask >> bit & 1) of[mask] |= bit << shift, shift += 8;
    }
  }
} kept_indices;
#endif

/// Appends the bins whose `kept` is negative.
/// @param to  end of the list; a whole vector is written
/// @returns the new end
template <class L>
[[gnu::always_inline]] inline std::int32_t* append(const Bins<L>& bins, const Bins<L>& kept,
                                                   std::int32_t* to) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (lane_count<L> == 8) {
    const auto mask = _mm512_movepi32_mask(__builtin_bit_cast(__m512i, kept));
    const auto packed = _mm512_maskz_compress_epi32(mask, __builtin_bit_cast(__m512i, bins));
    __builtin_memcpy(to, &packed, sizeof packed);
    return to + __builtin_popcount(mask);
  }
#endif
#if defined(__AVX2__)
  if constexpr (lane_count<L> == 4) {
    const auto mask = static_cast<unsigned>(_mm256_movemask_ps(__builtin_bit_cast(__m256, kept)));
    const auto indices = _mm_cvtsi64_si128(static_cast<long long>(kept_indices.of[mask]));
    const auto packed =
        _mm256_permutevar8x32_epi32(__builtin_bit_cast(__m256i, bins), _mm256_cvtepu8_epi32(indices));
    __builtin_memcpy(to, &packed, sizeof packed);
    return to + __builtin_popcount(mask);
  }
#endif
#pragma GCC unroll 16
  for (std::size_t i = 0; i < BinsOf<L>::count; ++i) {
    *to = bins[i];
    to += kept[i] < 0;
  }
  return to;
}

/// A Tally in registers; adds eight values at a time.
template <class L>
class FigureTally {
 public:
  [[gnu::always_inline]] explicit FigureTally(const Tally& tally) {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      low_[p] = load<L>(tally.min + p * lane_count<L>);
      sum_[p] = load<L>(tally.sum + p * lane_count<L>);
      high_[p] = broadcast<L>(tally.max);
    }
  }

  [[gnu::always_inline]] void add(const double* values) {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      const L value = load<L>(values + p * lane_count<L>);
      low_[p] = min(low_[p], value);
      high_[p] = max(high_[p], value);
      sum_[p] += value;
    }
  }

  /// @param increased  set in the lanes in which the maximum is larger than before
  [[gnu::always_inline]] void finish(Tally& tally, Bits<L>& increased) const {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      store(tally.sum + p * lane_count<L>, sum_[p]);
      store(tally.min + p * lane_count<L>, low_[p]);
      increased |= high_[p] > broadcast<L>(tally.max);
    }
  }

 private:
  static constexpr std::size_t packs = 8 / lane_count<L>;

  L low_[packs], high_[packs], sum_[packs];
};

/// A BinList in registers; adds `at_once` values at a time.
template <class L>
class FigureBins {
 public:
  static constexpr std::size_t at_once = BinsOf<L>::count;

  [[gnu::always_inline]] explicit FigureBins(const BinList& list) : counted_(list.counted), next_(list.next) {
    static_assert(sizeof below_ <= sizeof list.below);
    __builtin_memcpy(&below_, list.below, sizeof below_);
  }

  [[gnu::always_inline]] void add(const double* values) {
    const Bins<L> bins = bins_of<L>(values), from_begin = bins - counted_.begin;  // negative: below
    below_ -= from_begin >> 31;
    next_ = append<L>(bins, (~from_begin & (bins - counted_.end)) | (counted_.top - 1 - bins), next_);
  }

  [[gnu::always_inline]] void finish(BinList& list) const {
    __builtin_memcpy(list.below, &below_, sizeof below_);
    list.next = next_;
  }

 private:
  const CountedBins counted_;
  std::int32_t* next_;
  Bins<L> below_;
};

template <class L>
void tally(std::size_t count, const double* figures, std::uint64_t first, Tally* tallies, BinList* lists) {
  Bits<L> increased{};
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    FigureTally<L> figure(tallies[f]);
    if (lists) {
      FigureBins<L> bins(lists[f]);
      for (std::size_t i = 0; i < batch_size; i += 16) {
        figure.add(values + i);
        figure.add(values + i + 8);
        for (std::size_t j = 0; j < 16; j += bins.at_once) bins.add(values + i + j);
      }
      bins.finish(lists[f]);
    } else {
      for (std::size_t i = 0; i < batch_size; i += 8) figure.add(values + i);
    }
    figure.finish(tallies[f], increased);
  }
  std::int64_t any = 0;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) any |= increased[i];
  if (any) find_maxima<L>(figures, count, first, tallies);  // rare
}

}  // namespace
}  // namespace qerr::lanes
