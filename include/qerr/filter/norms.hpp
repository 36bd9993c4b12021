#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// lower <= value <= upper.
struct Interval {
  double lower = 0;
  double upper = 0;
};

struct Norms {
  double h2 =
      0;  ///< ||H||_2, sigma of the output for white input of unit sigma (paper, Eq. 28) [1/s^derivative]
  Interval l1;         ///< ||H||_1 = sum |h_k|, peak of the output for input bounded by 1 (paper, Eq. 26)
                       ///< [1/s^derivative]
  double dc_gain = 0;  ///< H(1) [1/s^derivative]
};

/// ||H||_2 = sqrt(sum h_k^2) = sqrt((1/pi) int |H|^2 dOmega/(1 + Omega^2)), w = j Omega [1/s^derivative].
///
/// Astrom's recursion (Introduction to Stochastic Control Theory, 1970, ch. 5) on the polynomials in w, in
/// double-double: no controller canonical form and no Lyapunov equation, so that low cut-offs and high orders
/// keep their digits. Relative error below 1e-14 on the oracle (f0/f from 1e-7, orders to 8).
/// @pre every section is stable
/// @throws Error (internal) when a section is not
double h2_norm(const Filter&);

/// An interval that contains ||H||_1 = sum |h_k| [1/s^derivative], of relative width below 1e-12 except for
/// extreme filters.
///
/// Partial fractions in double-double. Where h keeps its sign its sum is a difference of two values of the
/// step response; the sign changes are found by bounds on the differences of h, so the work grows with their
/// number and not with the filter's memory. The interval holds the proven tail and a bound on the rounding.
/// Filters with fast poles are summed directly, with the tail of Cauchy and Schwarz. The work is bounded:
/// past it the interval is wider, and valid.
/// @pre every section is stable
Interval l1_norm(const Filter&);

/// All at once.
Norms norms(const Filter&);

}  // namespace qerr
