#pragma once

#include "qerr/filter/filter.hpp"

namespace qerr {

/// lower <= value <= upper.
struct Interval {
  double lower = 0;
  double upper = 0;
};

/// |exact - value| <= error.
struct Estimate {
  double value = 0;
  double error = 0;
};

/// The norms of a filter, all in 1/s^derivative.
struct Norms {
  double h2 = 0;        ///< ||H||_2, sigma of the output for white input of unit sigma (paper, Eq. 28)
  double h2_error = 0;  ///< proven bound of |h2 - ||H||_2|, the final rounding to double included
  Interval l1;          ///< holds ||H||_1 = sum |h_k|, peak of the output for input bounded by 1 (Eq. 26)
  double dc_gain = 0;   ///< H(1)
};

/// ||H||_2 = sqrt(sum h_k^2) = sqrt((1/pi) int |H|^2 dOmega/(1 + Omega^2)), w = j Omega [1/s^derivative].
///
/// Astrom's recursion (Introduction to Stochastic Control Theory, 1970, ch. 5) on the polynomials in w: no
/// controller canonical form and no Lyapunov equation. It runs in balls (a number and a bound of its error),
/// in double-double first and with 1024 or 4096 bits where those do not prove 21 digits, so the result is the
/// exact norm rounded to double; the error bounds what is left, for the stated filter. Of coefficients given
/// by the user the bound also holds what their factoring into sections rounded (`Filter::deviation`).
/// @pre every section is stable
/// @throws Error (internal) when a section is not, or only after 1e-1000
Estimate h2_estimate(const Filter&);

/// The value of `h2_estimate`.
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
