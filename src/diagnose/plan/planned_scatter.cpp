#include "diagnose/plan/planned_scatter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/probability.hpp"
#include "diagnose/inference/model_choice.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/verdict/record_advice.hpp"

namespace qerr {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Argument in [0.01, 100] at which an increasing function reaches a value, by bisection; infinite if larger.
double argument_of(const std::function<double(double)>& increasing, double value) {
  double low = 0.01, high = 100;
  if (increasing(high) < value) return infinite;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (increasing(middle) < value ? low : high) = middle;
  }
  return high;
}

/// Weighted mean square of a column about its mean.
double variance(const Eigen::ArrayXd& x, const Eigen::ArrayXd& w) {
  const double mean = (w * x).sum() / w.sum();
  return (w * (x - mean).square()).sum() / w.sum();
}

/// Sizes from which random effects are detectable and identifiable at one encoder [counts].
class ScatterIdentifiability {
 public:
  ScatterIdentifiability(const PlannedRecord& r, const Identifiability& s, const PlanOptions& o)
      : reference_noise_(r.evidence.noise / r.evidence.step()),
        sigma_information_(s.information().log_sigma * s.readings()),
        position_information_(s.information().position * s.readings()),
        power_(o.power) {
    const Eigen::ArrayXd v = r.evidence.velocity.abs() / r.evidence.step();
    speed_ = std::sqrt((r.weight * v.square()).sum() / r.weight.sum());
    // Histogram of the readings by speed.
    constexpr Eigen::Index bins = 200;
    speeds_ = v.maxCoeff() * Eigen::ArrayXd::LinSpaced(bins, 0, 1);
    weight_ = Eigen::ArrayXd::Zero(bins);
    for (Eigen::Index k = 0; k < v.size(); ++k)
      weight_[speed_ > 0 ? std::lround(v[k] / v.maxCoeff() * (bins - 1)) : 0] += r.weight[k];
  }

  /// Smallest detectable rms: the estimate must exceed the thresholds of scatter_of with a one-sided
  /// probability of 95 %, the relative error of a standard deviation being 1/sqrt(information).
  double detectable() const {
    const double spread = 1 + 1.645 / std::sqrt(sigma_information_);
    const double ratio = std::max(scatter_beyond_reference * spread,
                                  std::exp(std::sqrt(noncentrality() / sigma_information_)));
    return std::max(reference_noise_ * std::sqrt(ratio * ratio - 1), scatter_worth_naming * spread);
  }

  /// Rms from which jitter is distinguished from noise, and noise from jitter.
  double jitter_from() const {
    if (speed_ == 0) return infinite;
    return argument_of([&](double x) { return sigma_information_ * variance(log_sigma(x), weight_); },
                       noncentrality());
  }
  double noise_from() const {
    if (speed_ == 0) return infinite;
    const auto distance = [&](double x) {
      const double log_noise = std::log(std::hypot(reference_noise_, x));
      double least = infinite;
      for (double c = 0.25 * x; c < 4 * x; c *= 1.05)
        least = std::min(least, (weight_ * (log_sigma(c) - log_noise).square()).sum());
      return sigma_information_ * least / weight_.sum();
    };
    return argument_of(distance, noncentrality());
  }

  /// Smallest detectable displacement of every second edge. Its rms about the mean is half of it; the mean
  /// may be due to an offset.
  double state_width() const {
    return std::max(2 * detectable(), 2 * std::sqrt(noncentrality() / position_information_));
  }

  double speed() const { return speed_; }  ///< rms [counts/s]

 private:
  double noncentrality() const { return noncentrality_for_power(2 * cannot_be_told, 1, power_); }

  /// Logarithm of sigma at every speed with a jitter that adds an rms of `x` counts.
  Eigen::ArrayXd log_sigma(double x) const {
    return 0.5 * (reference_noise_ * reference_noise_ + (x / speed_ * speeds_).square()).log();
  }

  double reference_noise_, sigma_information_, position_information_, power_, speed_ = 0;
  Eigen::ArrayXd speeds_, weight_;  ///< [counts/s], readings
};

PlannedEffect planned(const char* type, const Evidence& e, const char* parameter, double counts_per_size,
                      double detectable_counts, double identifiable_counts) {
  PlannedEffect p;
  p.effect = {type, e.joint, {}, {}};
  p.parameter = parameter;
  p.counts_per_size = counts_per_size;
  p.detectable = detectable_counts / counts_per_size;
  p.identifiable = std::max(p.detectable, identifiable_counts / counts_per_size);
  return p;
}

void add_correlated(PlannedEffect& p, const char* type, double separable_from, double correlation) {
  CorrelatedEffect c;
  c.effect = {type, p.effect.joint, {}, {}};
  c.correlation = correlation;
  c.separable_from = separable_from;
  c.record = record_advice(p.effect.type, type);
  p.correlated.push_back(std::move(c));
}

}  // namespace

std::vector<PlannedEffect> planned_scatter(const PlannedRecord& record,
                                           const Identifiability& identifiability,
                                           const PlanOptions& options) {
  const Evidence& e = record.evidence;
  const ScatterIdentifiability s(record, identifiability, options);
  const double detectable = s.detectable(), noise_from = s.noise_from(), jitter_from = s.jitter_from();
  const Eigen::ArrayXd v2 = e.velocity.square();
  const auto mean = [&](const Eigen::ArrayXd& x) { return (record.weight * x).sum() / record.weight.sum(); };
  const double correlation = mean(v2) / std::sqrt(std::max(mean(v2.square()), 1e-300));
  std::vector<PlannedEffect> list;
  list.push_back(planned("noise", e, "sigma", 1 / e.step(), detectable, noise_from));
  add_correlated(list.back(), "timing_jitter", noise_from * e.step(), correlation);
  if (s.speed() > 0) {
    list.push_back(planned("timing_jitter", e, "sigma", s.speed(), detectable, jitter_from));
    add_correlated(list.back(), "noise", jitter_from / s.speed(), correlation);
  }
  if (e.encoder.counts_per_period == 4)
    list.push_back(planned("state_width", e, "phase", 2 / std::numbers::pi, s.state_width(), 0));
  return list;
}

}  // namespace qerr
