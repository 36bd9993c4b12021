#include <cmath>

#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

Filter design(const FilterDesign& wanted) {
  const int states =
      checked_choice(wanted, "model", {"constant_velocity", "constant_acceleration"}) == "constant_velocity"
          ? 2
          : 3;
  if (parameter_group(wanted, {{"process_noise", "measurement_noise"}, {"tracking_index"}}) == 1) {
    const double index = checked_number(wanted, "tracking_index", 0, 1e15);
    return tracking_filter(wanted, spectral_factor(piecewise_noise(states, index)));
  }
  check_sample_rate(wanted.sample_rate);
  const double intensity = checked_number(wanted, "process_noise", 0, INFINITY);
  const double sigma = checked_number(wanted, "measurement_noise", 0, INFINITY);
  const double ratio = std::sqrt(intensity) * std::pow(wanted.sample_rate, 0.5 - states) / sigma;
  if (!(ratio > 1e-30 && ratio < 1e15)) {
    throw Error(
        "process_noise", "the filter leaves the range of double precision",
        "sqrt(process_noise T^" + std::to_string(2 * states - 1) + ")/measurement_noise = " + figure(ratio),
        "bring process and measurement noise closer together");
  }
  return tracking_filter(wanted, spectral_factor(continuous_noise(states, ratio)));
}

}  // namespace

FilterFamily kalman_family() {
  return {
      "kalman",
      "estimates the derivative itself: of the updated estimate x_hat(k|k) of a steady-state Kalman filter; "
      "no lag for "
      "motion as in the model; its highest derivative is late by (alpha/beta - 1/2) T (velocity) or (2 "
      "beta/gamma - "
      "1/2) T (acceleration) while that changes",
      {key::choice("model", "constant_velocity|constant_acceleration",
                   "state that is constant up to the process noise"),
       key::number("process_noise",
                   "intensity of the white acceleration [unit^2/s^3], or of the white jerk [unit^2/s^5], "
                   "unit: m or rad")
           .above(0),
       key::coordinate("measurement_noise", "sigma of the measured coordinate; goes with process_noise")
           .above(0),
       tracking_index_row()},
      design};
}

}  // namespace qerr
