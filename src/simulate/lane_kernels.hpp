#pragma once

#include "lane_errors.hpp"
#include "lane_filters.hpp"

namespace qerr::lanes {
namespace {

template <class L>
void positions(const SmoothPath& path, const double* time, double* to) {
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const L t = load<L>(time + i);
    L position = fma(path.velocity, t, broadcast<L>(path.center));
    for (std::size_t k = 0; k < path.count; ++k) {
      const Oscillation& o = path.oscillations[k];
      // Rounded as MotionPath::at does: late in a motion this is the larger part of its rounding errors.
      const L argument = rounded<L>(o.rate * t) + o.phase;
      position = fma(o.amplitude, sincos(argument).sine, position);
    }
    store(to + i, position);
  }
}

template <class L>
void mix(std::size_t n, const double* matrix, const double* from, double* to) {
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      L sum{};
      for (std::size_t column = 0; column < n; ++column) {
        const double factor = matrix[row * n + column];
        if (factor != 0) sum = fma(factor, load<L>(from + column * batch_size + i), sum);
      }
      store(to + row * batch_size + i, sum);
    }
}

template <class L>
[[gnu::always_inline]] inline L floor(const L& x) {
  L whole;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) whole[i] = __builtin_floor(x[i]);
  return whole;
}

template <class L>
bool quantize(const Quantizer& q, const double* position, double* counts, double* measured) {
  const double half = q.down ? 0 : 0.5;
  Bits<L> outside{};
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    // Divided as Encoder's quantize does, so that a tie is a tie here too.
    const L count = floor(load<L>(position + i) / q.resolution + half);
    outside |= ~(abs(count) <= 0x1p53);
    store(counts + i, count);
    store(measured + i, count * q.resolution);
  }
  return !any<L>(outside);
}

template <class L>
double largest(const double* row) {
  L all{};
#pragma GCC unroll 4
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) all = max(abs(load<L>(row + i)), all);
  double one = 0;
  for (std::size_t i = 0; i < lane_count<L>; ++i) one = one < all[i] ? all[i] : one;
  return one;
}

template <class L>
void sums(const double* rows, std::size_t width, std::size_t first, std::size_t last, double* to) {
  for (std::size_t c = 0; c < width; c += lane_count<L>) {
    L sum{};
    for (std::size_t i = first; i < last; ++i) sum += load<L>(rows + i * width + c);
    store(to + c, sum);
  }
}

/// The nearest whole number.
template <class L>
[[gnu::always_inline]] inline L nearest(const L& x) {
  if constexpr (lane_count<L> == 2) {  // without an instruction for it; |x| < 2^51
    constexpr double shift = 0x1.8p52;
    return (x + shift) - shift;
  }
  L whole;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) whole[i] = __builtin_nearbyint(x[i]);
  return whole;
}

/// Sums over the lags of `group` vectors of positions, from the small end.
template <class L, std::size_t group>
[[gnu::always_inline]] inline void weigh_losses(const double* r, std::size_t lags, const double* x,
                                                L (&sums)[group]) {
  constexpr auto lanes = lane_count<L>;
  L here[group];
#pragma GCC unroll 8
  for (std::size_t g = 0; g < group; ++g) {
    here[g] = load<L>(x + g * lanes);
    sums[g] = L{};
  }
  for (std::size_t n = lags; n-- > 1;) {
#pragma GCC unroll 8
    for (std::size_t g = 0; g < group; ++g) {
      const L moved = here[g] - load<L>(x + g * lanes - n), part = abs(moved - nearest(moved));
      sums[g] = fma(r[n], fma(-part, part, part), sums[g]);
    }
  }
}

/// Positions are lanes, so that the sums over the lags need no adding up across them.
template <class L>
double losses(const double* r, std::size_t lags, const double* x, std::size_t count) {
  constexpr std::size_t lanes = lane_count<L>, group = 4;
  double sum = 0;
  std::size_t k = 0;
  for (; k + group * lanes <= count; k += group * lanes) {
    L sums[group];
    weigh_losses(r, lags, x + k, sums);
    for (std::size_t i = 0; i < lanes; ++i) sum += (sums[0][i] + sums[1][i]) + (sums[2][i] + sums[3][i]);
  }
  for (; k < count; k += lanes) {
    L sums[1];
    weigh_losses(r, lags, x + k, sums);
    for (std::size_t i = 0; i < lanes && k + i < count; ++i) sum += sums[0][i];
  }
  return sum;
}

template <int n, class L = Lanes<n>>
constexpr SimulationKernels simulation_kernels{n,           errors_room<L>, positions<L>, mix<L>,
                                               quantize<L>, largest<L>,     errors<L>,    sums<L>,
                                               section<L>,  taps<L>,        tally<L>,     losses<L>};

}  // namespace
}  // namespace qerr::lanes
