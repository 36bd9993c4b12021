#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// The poles are 1/p of the Chebyshev I poles for 1/epsilon^2 = 10^(attenuation/10) - 1, the zeros
/// +-j/cos(theta_i).
Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 3, 1, max_order);
  const double attenuation = checked_number(wanted, "attenuation", 0, 300, 40.0);
  const Real mu = asinh(sqrt(expm1(log(Real(10)) * attenuation / 10))) / order;
  Prototype prototype;
  for (int i = 0; i < order / 2; ++i) {
    const Real theta = pi256() * (2 * i + 1) / (2 * order);
    const ComplexDoubleDouble p{to_double_double(-sinh(mu) * sin(theta)),
                                to_double_double(cosh(mu) * cos(theta))};
    prototype.poles.push_back(conj(ComplexDoubleDouble(1.0) / p));
    prototype.zeros.push_back(to_double_double(1 / cos(theta)));
  }
  if (order % 2 == 1) prototype.poles.push_back(to_double_double(-1 / sinh(mu)));
  return bilinear_lowpass(wanted, prototype);
}

}  // namespace

FilterFamily chebyshev2_family() {
  return {"chebyshev2",
          "back differences, then a Chebyshev low-pass with ripple beyond the cut-off (bilinear, pre-warped)",
          {order_row(3),
           cutoff_row(
               "where the attenuation is first reached (the stop band's edge), below half the sample rate"),
           attenuation_row("beyond the cut-off, in dB")},
          design};
}

}  // namespace qerr
