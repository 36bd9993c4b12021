#include <cmath>
#include <optional>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

class HeldDifference {
 public:
  explicit HeldDifference(const EstimatorDesign& d) : time_constant_(d.numbers.at("time_constant")) {}

  double operator()(const CounterSample& sample) {
    if (!last_) last_ = sample;
    if (sample.count == last_->count) return velocity_;
    const double lasted = sample.time - last_->time;
    const double keep = time_constant_ > 0 ? std::exp(-lasted / time_constant_) : 0;
    velocity_ = keep * velocity_ + (1 - keep) * (sample.count - last_->count) / lasted;
    last_ = sample;
    return velocity_;
  }

 private:
  double time_constant_, velocity_ = 0;
  std::optional<CounterSample> last_;  // at which the count had changed; its edges are not read
};

}  // namespace

/// At a sample whose count has changed (x - x_last)/(t - t_last), through a low-pass of the first order with
/// a = exp(-(t - t_last)/T_f); else held.
EstimatorKind held_difference_estimator() {
  return {
      "held_difference",
      "a low-pass of the difference to the last change, updated only when the count has changed (SimpleFOC)",
      {key::number("time_constant", "T_f of the low-pass; 0: none", dimension::time)
           .otherwise(0.005)
           .from(0)},
      [](const EstimatorDesign& d, const Counter&) { return VelocityEstimate(HeldDifference(d)); }};
}

}  // namespace qerr
