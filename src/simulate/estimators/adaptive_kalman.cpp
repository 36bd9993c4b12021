#include <algorithm>
#include <cmath>
#include <optional>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

/// Position and velocity in counts and counts a sample; measurement variance 1/12.
class AdaptiveKalman {
 public:
  AdaptiveKalman(const EstimatorDesign& d, double period)
      : gain_(d.numbers.at("adaptation")), period_(period) {}

  double operator()(const CounterSample& sample) {
    if (!started_) {
      started_ = true;
      x_ = sample.count;
      return 0;
    }
    // White acceleration of intensity q over a sample: q [1/3 1/2; 1/2 1].
    x_ += v_;
    pxx_ += 2 * pxv_ + pvv_ + q_ / 3;
    pxv_ += pvv_ + q_ / 2;
    pvv_ += q_;
    constexpr double noise = 1.0 / 12;
    const double innovation = sample.count - x_, s = pxx_ + noise;
    const double kx = pxx_ / s, kv = pxv_ / s;
    x_ += kx * innovation;
    v_ += kv * innovation;
    pvv_ -= kv * pxv_;
    pxv_ *= 1 - kx;
    pxx_ *= 1 - kx;
    constexpr double least = 1e-12, most = 1e6, outlier = 9;
    q_ = std::clamp(q_ * std::exp(gain_ * (std::min(innovation * innovation / s, outlier) - 1)), least, most);
    return v_ / period_;
  }

 private:
  double gain_, period_;
  bool started_ = false;
  double x_ = 0, v_ = 0, pxx_ = 1, pxv_ = 0, pvv_ = 1, q_ = 1e-2;
};

}  // namespace

/// A Kalman filter of position and velocity whose process noise follows the innovations: with their variance
/// S as the filter expects it, q is multiplied by exp(adaptation (nu^2/S - 1)) at each sample, nu^2/S at most
/// 9, so that it stays where the mean of nu^2 is S.
EstimatorKind adaptive_kalman_estimator() {
  return {"adaptive_kalman",
          "a Kalman filter of position and velocity whose process noise follows the innovations",
          {key::number(
               "adaptation",
               "by how much of the innovation's excess the logarithm of the process noise changes a sample")
               .otherwise(0.05)
               .within(0, 1)},
          [](const EstimatorDesign& d, const Counter& c) {
            return VelocityEstimate(AdaptiveKalman(d, c.period));
          }};
}

}  // namespace qerr
