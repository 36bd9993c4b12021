#include "qerr/bound/velocity_estimators.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {

namespace {

/// Rounds a number that is an integer up to the rounding errors of a few operations.
double snapped(double x) {
  const double nearest = std::round(x);
  return std::abs(x - nearest) <= 8 * std::numeric_limits<double>::epsilon() * x ? nearest : x;
}

}  // namespace

EstimatorError finite_difference_error(double resolution, double sample_rate, double speed) {
  const double unit = resolution * sample_rate;
  const double counts = snapped(std::abs(speed) / unit), part = counts - std::floor(counts);
  return {unit, unit, part == 0 ? 0 : unit * std::max(part, 1 - part)};
}

EstimatorError inverse_time_error(double resolution, double clock, double speed) {
  const double unit = resolution * clock;
  if (speed == 0) return {};
  const double alpha = snapped(unit / std::abs(speed)), m = std::floor(alpha);
  if (m < 1) {
    constexpr double unbounded = std::numeric_limits<double>::infinity();
    return {unbounded, unbounded, unbounded};
  }
  const double constant = m == alpha ? 0 : unit * std::max(1 / m - 1 / alpha, 1 / alpha - 1 / (m + 1));
  return {unit / m, unit / (m * (m + 1)), constant};
}

double estimator_crossing(double resolution, double sample_rate, double clock) {
  const double ratio = clock / sample_rate;
  // (m - 1) m < m^2 <= ratio < (m + 1)^2: the least integer is m or the next one.
  double m = std::max(1.0, std::floor(std::sqrt(ratio)));
  if (m * (m + 1) < ratio) m += 1;
  return resolution * clock / m;
}

double worst_case_snr_db(double speed, double error) { return 20 * std::log10(std::abs(speed) / error); }

}  // namespace qerr
