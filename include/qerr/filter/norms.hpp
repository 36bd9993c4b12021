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
  double h2_error = 0;  ///< bound of |h2 - ||H||_2|, the final rounding to double included
  Interval l1;          ///< holds ||H||_1 = sum |h_k|, peak of the output for input bounded by 1 (Eq. 26)
  double dc_gain = 0;   ///< H(1)
};

/// ||H||_2 = sqrt(sum h_k^2) = sqrt((1/pi) int |H|^2 dOmega/(1 + Omega^2)), w = j Omega [1/s^derivative].
///
/// Astrom's recursion (Introduction to Stochastic Control Theory, 1970, ch. 5) on the polynomials in w: no
/// controller canonical form and no Lyapunov equation. It runs in balls (a number and a bound of its error),
/// in double-double first and with 1024 or 4096 bits where those do not prove 21 digits, so the result is the
/// exact norm rounded to double; the error is a proven bound of what is left, for the stated filter. Of
/// coefficients given by the user it also holds what their factoring into sections rounded
/// (`Filter::deviation`), of a family's design an allowance for the rounding of its coefficients, 1e-15 of
/// the norm a section (`Filter::designed`).
/// @pre every section is stable
/// @throws Error (internal) when that is not so, or out of range
Estimate h2_estimate(const Filter&);

/// The value of `h2_estimate`.
double h2_norm(const Filter&);

/// An interval that is proven to contain ||H||_1 = sum |h_k| [1/s^derivative], rounding included.
///
/// Fast filters are summed directly, in double-double with a running error bound. Of slow ones the partial
/// fractions are taken: where h keeps its sign its sum is a difference of two values of the step response, so
/// the work grows with the changes of sign and not with the filter's memory; modes leave as they die, and the
/// turns of a resonance that is left alone, of which there may be billions, are summed by Euclid's algorithm
/// on their signs. What is left out is bounded by Cauchy and Schwarz:
/// sum_{k>=K} |h_k| <= r^K (1 - r^2)^(-1/2) ||H(rz)||_2.
///
/// The relative width is below 1e-12 where the memory 1/(1 - |z|) is below some ten thousand samples, for
/// real poles and where all modes but the slowest die within some hundred thousand changes of sign or a
/// million samples, however slow they are: so for all families but slow elliptic low-passes of order 17 and
/// more (1 dB of ripple) or 19 and more (0.1 dB), whose two slowest resonances both ring for 10^4 turns and
/// more. It is not there, nor where several resonances, or repeated ones, or a resonance and a real pole
/// share such a memory, or poles near z = 1 and z = -1 do: there only the order of magnitude may be known.
/// The time stays about two seconds at most. A family's interval also covers the rounding of its
/// coefficients, 1e-15 a section.
/// @pre every section is stable
Interval l1_norm(const Filter&);

/// All at once.
Norms norms(const Filter&);

}  // namespace qerr
