#include <cmath>
#include <optional>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

class SlidingMode {
 public:
  /// @param acceleration  [counts/s^2]
  SlidingMode(double acceleration, double period) : acceleration_(acceleration), period_(period) {}

  double operator()(const CounterSample& sample) {
    if (!position_) position_ = sample.count;
    const double error = *position_ - sample.count, sign = error > 0 ? 1 : error < 0 ? -1 : 0;
    *position_ += period_ * (velocity_ - 1.5 * std::sqrt(acceleration_ * std::abs(error)) * sign);
    velocity_ -= period_ * 1.1 * acceleration_ * sign;
    return velocity_;
  }

 private:
  double acceleration_, period_, velocity_ = 0;
  std::optional<double> position_;
};

}  // namespace

/// Levant's first-order differentiator, by Euler's method: e = z0 - x, z0 += T (z1 - 1.5 sqrt(L |e|) sgn e),
/// z1 -= 1.1 T L sgn e; the estimate is z1.
EstimatorKind robust_differentiator_estimator() {
  return {"robust_differentiator",
          "Levant's sliding mode: exact in continuous time for accelerations up to a bound, without noise",
          {key::number("acceleration", "L, bound of the joint's acceleration [rad/s^2 or m/s^2]")
               .above(0)
               .needed()},
          [](const EstimatorDesign& d, const Counter& c) {
            return VelocityEstimate(SlidingMode(d.numbers.at("acceleration") / c.resolution, c.period));
          }};
}

}  // namespace qerr
