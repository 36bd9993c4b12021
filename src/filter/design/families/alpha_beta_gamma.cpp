#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// Hurwitz's conditions on gamma/2 + 2 beta w + (4 alpha - gamma/2) w^2 + (8 - 4 alpha - 2 beta) w^3.
bool stable(DoubleDouble alpha, DoubleDouble beta, DoubleDouble gamma) {
  const DoubleDouble rest = DoubleDouble(4) - DoubleDouble(2) * alpha - beta;
  const DoubleDouble cross = alpha * (DoubleDouble(4) * beta + gamma) - DoubleDouble(2) * gamma;
  return rest.hi > 4e-16 && cross.hi > 4e-16 * gamma.hi;
}

Filter design(const FilterDesign& wanted) {
  if (parameter_group(wanted, {{"alpha", "beta", "gamma"}, {"tracking_index"}}) == 1) {
    const double index = checked_number(wanted, "tracking_index", 0, 1e15);
    return tracking_filter(wanted, spectral_factor(piecewise_noise(3, index)));
  }
  const DoubleDouble alpha = checked_number(wanted, "alpha", 0, 2),
                     beta = checked_number(wanted, "beta", 0, 4),
                     gamma = checked_number(wanted, "gamma", 0, 16);
  if (!stable(alpha, beta, gamma)) {
    throw Error("gamma",
                "the filter is not stable: it needs gamma > 0, 2 alpha + beta < 4 and alpha (4 beta + gamma) "
                "> 2 gamma",
                "alpha " + figure(alpha.hi) + ", beta " + figure(beta.hi) + ", gamma " + figure(gamma.hi),
                "use smaller gains, gamma the smallest");
  }
  const DoubleDouble half = DoubleDouble(0.5) * gamma, two = 2, four = 4;
  return tracking_filter(
      wanted, {half, two * beta, four * alpha - half, DoubleDouble(8) - four * alpha - two * beta});
}

}  // namespace

FilterFamily alpha_beta_gamma_family() {
  return {
      "alpha_beta_gamma",
      "estimates position, velocity or acceleration itself: x += alpha r, v += beta r/T, a += gamma "
      "r/(2 T^2) (Kalata), r the residual of the prediction; no lag at constant acceleration, the "
      "acceleration late by (2 beta/gamma - 1/2) T under jerk",
      {position_gain_row(), velocity_gain_row(),
       key::number("gamma", "gain of the acceleration; alpha (4 beta + gamma) > 2 gamma").above(0).up_to(16),
       tracking_index_row()},
      design};
}

}  // namespace qerr
