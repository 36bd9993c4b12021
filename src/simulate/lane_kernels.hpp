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
void sums(const double* rows, std::size_t count, std::size_t first, std::size_t last, double* to) {
  const bool whole = first == 0 && last == batch_size;
  for (std::size_t row = 0; row < count; ++row) {
    const double* const values = rows + row * batch_size;
    double sum = 0;
    if (whole) {
      L all = load<L>(values);
      for (std::size_t i = lane_count<L>; i < batch_size; i += lane_count<L>) all += load<L>(values + i);
      for (std::size_t i = 0; i < lane_count<L>; ++i) sum += all[i];
    } else {
      for (std::size_t i = first; i < last; ++i) sum += values[i];
    }
    to[row] = sum;
  }
}

template <int n, class L = Lanes<n>>
constexpr SimulationKernels simulation_kernels{n,         errors_room<L>, positions<L>, mix<L>,  quantize<L>,
                                               errors<L>, sums<L>,        section<L>,   taps<L>, tally<L>};

}  // namespace
}  // namespace qerr::lanes
