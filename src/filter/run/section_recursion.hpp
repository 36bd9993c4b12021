#pragma once

#include <cstddef>

// The recursion of a filter section, for numbers of any kind: double, DoubleDouble, vectors of lanes.
//
// Kernel sources (lane_*.cpp), which are compiled once per instruction set, include this header. So its
// functions are inlined and have internal linkage (see lanes/lanes.hpp), and it includes nothing.

namespace qerr {

/// A Section as trapezoidal integrators, divided by a0 + a1 + a2:
///
///     second order   high = x - k0 s2 - k1 s1    band = high + s1    low = band + s2
///                    s1' = s1 + 2 high           s2' = low + band
///     first order    high = x - k0 s1            band = high         low = high + s1
///                    s1' = s1 + 2 high
///     output         y = b0 low + b1 band + b2 high
///
/// k0 = a0/(a0 + a1 + a2), k1 = (a0 + a1)/(a0 + a1 + a2). The trapezoidal integrator is 1/w: a section is
/// solved for its highest derivative w^2 u (or w u), and the others are integrals of it. So a high-pass
/// output is never the difference of two large low-pass ones, and low cut-offs keep their digits.
template <class Number>
struct NormalizedSection {
  bool second = false;
  Number k0{}, k1{}, b0{}, b1{}, b2{};
};

/// The states of a section's integrators; s2 is 0 for first order.
template <class Number>
struct SectionState {
  Number s1{}, s2{};
};

/// u, w u and w^2 u of a section, scaled: 1/a, w/a and w^2/a of its input (band = high for first order).
template <class Number>
struct SectionSignals {
  Number high, band, low;
};

namespace {

template <class Number>
[[gnu::always_inline]] inline Number twice(const Number& x) {
  return 2 * x;
}

/// One sample x through a section.
template <bool second, class Number>
[[gnu::always_inline]] inline SectionSignals<Number> advance(const Number& k0, const Number& k1,
                                                             const Number& x, SectionState<Number>& state) {
  if constexpr (second) {
    const Number high = (x - k0 * state.s2) - k1 * state.s1;
    const Number band = high + state.s1, low = state.s2 + band;
    state.s1 = twice(high) + state.s1;
    state.s2 = low + band;
    return {high, band, low};
  } else {
    const Number high = x - k0 * state.s1, low = state.s1 + high;
    state.s1 = twice(high) + state.s1;
    return {high, high, low};
  }
}

template <bool second, class Number>
[[gnu::always_inline]] inline Number output(const Number& b0, const Number& b1, const Number& b2,
                                            const SectionSignals<Number>& u) {
  if constexpr (second) return b0 * u.low + (b1 * u.band + b2 * u.high);
  return b0 * u.low + b1 * u.band;
}

}  // namespace

// The table of kernels of RowFilter; the kernel source includes this, and nothing that has code of its own.
// Lanes are channels: neighbours in a row, of `width` numbers, a multiple of the lanes.

struct FilterKernels {
  /// Rows `stride` numbers apart through a section, into rows `width` apart.
  /// @param state  [s1, s2][width]
  /// @param out  may be `in` where stride = width
  void (*section)(const NormalizedSection<double>&, const double* in, std::size_t stride, std::size_t rows,
                  std::size_t width, double* state, double* out);
  /// out[row] = sum_k taps[k] in[row - k].
  /// @param in  the row of the first output; the `count` - 1 rows before it precede it in memory
  void (*taps)(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
               double* out);
};

}  // namespace qerr
