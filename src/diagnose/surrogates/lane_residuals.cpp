#include "diagnose/surrogates/lane_surrogates.hpp"
#include "lanes/select_kernels.hpp"

// Statistics and filters of the residuals of surrogates, one surrogate per lane.

namespace qerr::lanes {
namespace {

template <class L>
void sines(const double* angle, std::size_t count, double* sine, double* cosine) {
  constexpr auto lanes = lane_count<L>;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const SineCosine<L> wave = sincos(load<L>(angle + i));
    store(sine + i, wave.sine);
    store(cosine + i, wave.cosine);
  }
  for (; i < count; ++i) {
    const SineCosine<L> wave = sincos(broadcast<L>(angle[i]));
    sine[i] = wave.sine[0];
    cosine[i] = wave.cosine[0];
  }
}

template <class L>
void moments(const double* in, std::size_t rows, std::size_t width, const MomentLanes& m) {
  in_groups<4, L>(0, width, [&]<int group>(std::size_t lane) {
    L sum[group], square[group], lagged[group], last[group];
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      sum[g] = load<L>(m.sum + at);
      square[g] = load<L>(m.square + at);
      lagged[g] = load<L>(m.lagged + at);
      last[g] = load<L>(m.last + at);
    }
    for (std::size_t k = 0; k < rows; ++k) {
#pragma GCC unroll 4
      for (int g = 0; g < group; ++g) {
        const L x = load<L>(in + k * width + lane + g * lane_count<L>);
        sum[g] += x;
        square[g] = fma(x, x, square[g]);
        lagged[g] = fma(x, last[g], lagged[g]);
        last[g] = x;
      }
    }
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      store(m.sum + at, sum[g]);
      store(m.square + at, square[g]);
      store(m.lagged + at, lagged[g]);
      store(m.last + at, last[g]);
    }
  });
}

template <class L>
void means(const double* in, std::size_t rows, std::size_t each, std::size_t width, double* out) {
  const double part = 1 / static_cast<double>(each);
  for (; rows >= each; rows -= each, in += each * width, out += width)
    for (std::size_t lane = 0; lane < width; lane += lane_count<L>) {
      L sum{};
      for (std::size_t k = 0; k < each; ++k) sum += load<L>(in + k * width + lane);
      store<L>(out + lane, sum * part);
    }
}

template <class L>
void project(const double* column, const double* in, std::size_t rows, std::size_t width, double* sums) {
  in_groups<4, L>(0, width, [&]<int group>(std::size_t lane) {
    L sum[group];
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) sum[g] = load<L>(sums + lane + g * lane_count<L>);
    for (std::size_t k = 0; k < rows; ++k) {
#pragma GCC unroll 4
      for (int g = 0; g < group; ++g)
        sum[g] = fma(column[k], load<L>(in + k * width + lane + g * lane_count<L>), sum[g]);
    }
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) store(sums + lane + g * lane_count<L>, sum[g]);
  });
}

/// a + b in the lanes of the mask, else a.
template <class Mask, class Any>
[[gnu::always_inline]] inline Any added_where(const Mask& mask, const Any& a, const Any& b) {
  if constexpr (lane_count<Mask> == 8) return mask != 0 ? a + b : a;  // one instruction
  return a + (mask != 0 ? b : Any{});
}

template <class L>
void by_state(const double* in, const double* state, std::size_t rows, std::size_t width, double* sums,
              double* counts) {
  for (std::size_t lane = 0; lane < width; lane += lane_count<L>) {
    // In the order of `moments`: if all readings have one state, its mean equals the mean of all bitwise.
    L sum[4];
#pragma GCC unroll 4
    for (int s = 0; s < 4; ++s) sum[s] = load<L>(sums + s * width + lane);
    Bits<L> count[4] = {};
    for (std::size_t k = 0; k < rows; ++k) {
      const L x = load<L>(in + k * width + lane), in_state = load<L>(state + k * width + lane);
#pragma GCC unroll 4
      for (int s = 0; s < 4; ++s) {
        const Bits<L> equal = in_state == static_cast<double>(s);
        sum[s] = added_where(equal, sum[s], x);
        count[s] = added_where(equal, count[s], Bits<L>{} + 1);
      }
    }
#pragma GCC unroll 4
    for (int s = 0; s < 4; ++s) {
      const std::size_t at = s * width + lane;
      store(sums + at, sum[s]);
      store<L>(counts + at, load<L>(counts + at) + number_of<L>(__builtin_bit_cast(Words<L>, count[s])));
    }
  }
}

/// Vector of as many 32-bit integers as L has lanes.
template <class L>
struct HalvesOf {
  typedef std::int32_t type __attribute__((vector_size(sizeof(L) / 2)));
};
template <class L>
using Halves = typename HalvesOf<L>::type;

/// Stores the bins of all rows before counting: extracting the lanes from a register one by one would be
/// slower.
template <class L>
void distribute(const double* in, double middle, std::size_t rows, std::size_t width, std::int32_t* places,
                std::uint32_t* bins) {
  constexpr double last = residual_bins - 0.5, per_count = 0.5 * residual_bins;
  for (std::size_t i = 0; i < rows * width; i += lane_count<L>) {
    const L place = (load<L>(in + i) - middle + 1) * per_count;
    const L inside = max(min(place, broadcast<L>(last)), L{});
    const auto bin = __builtin_convertvector(inside, Halves<L>);
    __builtin_memcpy(places + i, &bin, sizeof bin);
  }
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t lane = 0; lane < width; lane += 8, places += 8) {
      std::uint32_t* const of_lane = bins + lane * residual_bins;
#pragma GCC unroll 8
      for (std::size_t i = 0; i < 8; ++i) ++of_lane[i * residual_bins + static_cast<std::size_t>(places[i])];
    }
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const ResidualKernels& compiled_kernels<ResidualKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr ResidualKernels kernels{lane_count<L>, sines<L>,   draw<L>,     read<L>,      moments<L>,
                                           means<L>,      project<L>, by_state<L>, distribute<L>};
  return kernels;
}

}  // namespace qerr
