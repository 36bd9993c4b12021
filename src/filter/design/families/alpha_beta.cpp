
#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// beta for a damping ratio zeta: the smaller root of alpha^2 = zeta^2 beta (4 - 2 alpha - beta).
DoubleDouble beta_of_damping(double alpha, double damping) {
  const DoubleDouble a = alpha, ratio = a / DoubleDouble(damping), middle = DoubleDouble(2) - a;
  const DoubleDouble square = middle * middle - ratio * ratio;
  if (square.hi < -2e-11 * ratio.hi * ratio.hi) {  // the 12 digits of the remedy suffice
    throw Error("damping", "the damping ratio must be at least alpha/(2 - alpha)",
                figure(damping) + " with alpha " + figure(alpha),
                alpha < 2 ? "use at least " + figure(alpha / (2 - alpha)) + "; 1 is critical damping"
                          : "use alpha below 2");
  }
  return ratio * ratio / (middle + sqrt(square < DoubleDouble(0) ? DoubleDouble(0) : square));
}

Filter design(const FilterDesign& wanted) {
  const std::size_t group =
      parameter_group(wanted, {{"alpha", "beta"}, {"alpha", "damping"}, {"tracking_index"}});
  if (group == 2) {
    const double index = checked_number(wanted, "tracking_index", 0, 1e15);
    return tracking_filter(wanted, spectral_factor(piecewise_noise(2, index)));
  }
  const double alpha = checked_number(wanted, "alpha", 0, 2);
  const DoubleDouble beta = group == 0 ? DoubleDouble(checked_number(wanted, "beta", 0, 4))
                                       : beta_of_damping(alpha, checked_number(wanted, "damping", 0, 1e6));
  const DoubleDouble rest = DoubleDouble(4) - DoubleDouble(2 * alpha) - beta;
  if (!(rest.hi > 4e-16)) {
    throw Error(group == 0 ? "beta" : "damping",
                "the filter is not stable: it needs alpha > 0, beta > 0 and 2 alpha + beta < 4",
                "alpha " + figure(alpha) + ", beta " + figure(static_cast<double>(beta)),
                "use smaller gains");
  }
  return tracking_filter(wanted, {beta, DoubleDouble(2 * alpha), rest});
}

}  // namespace

FilterFamily alpha_beta_family() {
  return {"alpha_beta",
          "estimates position or velocity itself: x += alpha r, v += beta r/T, r the residual of the "
          "prediction x + T v; no lag at constant velocity, the velocity late by (alpha/beta - 1/2) T under "
          "acceleration",
          {position_gain_row(), velocity_gain_row(),
           key::number("damping",
                       "damping ratio in place of beta: alpha/sqrt(beta (4 - 2 alpha - beta)); 1 is critical")
               .above(0),
           tracking_index_row()},
          design};
}

}  // namespace qerr
