#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// Poles -sinh(mu) sin(theta_i) +- j cosh(mu) cos(theta_i), mu = asinh(1/epsilon)/n, theta_i = pi (2i +
/// 1)/(2n), epsilon^2 = 10^(ripple/10) - 1. Even orders have the gain of the bottom of the ripple at 0 Hz.
Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 3, 1, max_order);
  const double ripple = checked_number(wanted, "ripple", 0, 60, 1.0);
  const Real epsilon = sqrt(expm1(log(Real(10)) * ripple / 10)), mu = asinh(1 / epsilon) / order;
  Prototype prototype;
  for (int i = 0; i < order / 2; ++i) {
    const Real theta = pi256() * (2 * i + 1) / (2 * order);
    prototype.poles.push_back(
        {to_double_double(-sinh(mu) * sin(theta)), to_double_double(cosh(mu) * cos(theta))});
  }
  if (order % 2 == 1) prototype.poles.push_back(to_double_double(-sinh(mu)));
  if (order % 2 == 0) prototype.gain = attenuated(ripple);
  return bilinear_lowpass(wanted, prototype);
}

}  // namespace

FilterFamily chebyshev1_family() {
  return {"chebyshev1",
          "back differences, then a Chebyshev low-pass with ripple below the cut-off (bilinear, "
          "pre-warped); even orders start at -ripple, as in scipy and MATLAB",
          {order_row(3), cutoff_row("end of the ripple, below half the sample rate"), ripple_row()},
          design};
}

}  // namespace qerr
