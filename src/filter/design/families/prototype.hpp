#pragma once

#include <vector>

#include "filter/design/families/families.hpp"
#include "filter/norms/ball.hpp"
#include "filter/norms/complex.hpp"

namespace qerr {

/// An analog low-pass with its cut-off at 1 rad/s.
struct Prototype {
  std::vector<ComplexDoubleDouble> poles;  ///< real ones and, of each pair, the upper one
  std::vector<DoubleDouble> zeros;         ///< b of each pair +-jb
  DoubleDouble gain = 1;                   ///< at 0 Hz
};

/// The section 1/((1 - x/p)(1 - x/p*)), or 1/(1 - x/p) for a real p, at x = slope * w.
Section section_of_pole(ComplexDoubleDouble p, DoubleDouble slope);

/// 1/rho of the pre-warped bilinear transform, rho = tan(pi cutoff/rate).
DoubleDouble prewarped_slope(double cutoff, double rate);

/// 10^(-decibels/20).
DoubleDouble attenuated(double decibels);

// The coefficients of a design are rounded to double-double, not to double: far below its cut-off the
// response of a low-pass is 1 up to the last digits of these.
using Real = Binary256;
Real asinh(const Real&);

/// The differences of the derivative, then the prototype at s = w/rho, rho = tan(pi f0 T): the bilinear
/// transform, pre-warped so that the prototype's 1 rad/s is exactly at f0. No polynomial is expanded in z, so
/// that the accuracy does not depend on f0 T.
/// @throws Error (input; key `cutoff` or `derivative`)
Filter bilinear_lowpass(const FilterDesign&, const Prototype&);

}  // namespace qerr
