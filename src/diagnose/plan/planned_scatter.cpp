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

/// Where a rising function reaches a value, between 0.01 and 100; infinite beyond.
double reaches(const std::function<double(double)>& rising, double value) {
  double low = 0.01, high = 100;
  if (rising(high) < value) return infinite;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (rising(middle) < value ? low : high) = middle;
  }
  return high;
}

/// Weighted mean square of a column about its mean.
double variance(const Eigen::ArrayXd& x, const Eigen::ArrayXd& w) {
  const double mean = (w * x).sum() / w.sum();
  return (w * (x - mean).square()).sum() / w.sum();
}

class Scattered {
 public:
  Scattered(const PlannedRecord& r, const Sight& s, const PlanOptions& o)
      : own_(r.evidence.noise / r.evidence.step()),
        total_(s.information().scatter * s.readings()),
        position_(s.information().position * s.readings()),
        power_(o.power) {
    const Eigen::ArrayXd v = r.evidence.velocity.abs() / r.evidence.step();
    speed_ = std::sqrt((r.weight * v.square()).sum() / r.weight.sum());
    // The readings by their speed: fine enough for anything as broad as this.
    constexpr Eigen::Index bins = 200;
    speeds_ = v.maxCoeff() * Eigen::ArrayXd::LinSpaced(bins, 0, 1);
    weight_ = Eigen::ArrayXd::Zero(bins);
    for (Eigen::Index k = 0; k < v.size(); ++k)
      weight_[speed_ > 0 ? std::lround(v[k] / v.maxCoeff() * (bins - 1)) : 0] += r.weight[k];
  }

  /// Rms that is seen, at least [counts].
  double seen() const {
    const double spread = 1 + 1.645 / std::sqrt(total_);
    const double ratio = std::max(scatter_beyond_reference * spread, std::exp(std::sqrt(need() / total_)));
    return std::max(own_ * std::sqrt(ratio * ratio - 1), scatter_worth_naming * spread);
  }

  /// Rms from which jitter is no noise, and noise no jitter [counts].
  double jitter_from() const {
    if (speed_ == 0) return infinite;
    return reaches([&](double x) { return total_ * variance(log_sigma(x), weight_); }, need());
  }
  double noise_from() const {
    if (speed_ == 0) return infinite;
    const auto distance = [&](double x) {
      const double log_noise = std::log(std::hypot(own_, x));
      double least = infinite;
      for (double c = 0.25 * x; c < 4 * x; c *= 1.05)
        least = std::min(least, (weight_ * (log_sigma(c) - log_noise).square()).sum());
      return total_ * least / weight_.sum();
    };
    return reaches(distance, need());
  }

  /// Displacement of every second edge that is seen [counts]: half of it is rms, the mean is an offset's.
  double states() const { return std::max(2 * seen(), 2 * std::sqrt(need() / position_)); }

  double speed() const { return speed_; }  ///< rms [counts/s]

 private:
  double need() const { return noncentrality_for_power(2 * cannot_be_told, 1, power_); }

  /// With a jitter that adds an rms of `x` counts.
  Eigen::ArrayXd log_sigma(double x) const {
    return 0.5 * (own_ * own_ + (x / speed_ * speeds_).square()).log();
  }

  double own_, total_, position_, power_, speed_ = 0;
  Eigen::ArrayXd speeds_, weight_;  ///< [counts/s], readings
};

PlannedEffect planned(const char* type, const Evidence& e, const char* parameter, double counts_per_size,
                      double seen_counts, double named_counts) {
  PlannedEffect p;
  p.effect = {type, e.joint, {}, {}};
  p.parameter = parameter;
  p.counts_per_size = counts_per_size;
  p.seen = seen_counts / counts_per_size;
  p.named = std::max(p.seen, named_counts / counts_per_size);
  return p;
}

void add_rival(PlannedEffect& p, const char* type, double size, double correlation) {
  Rival r;
  r.effect = {type, p.effect.joint, {}, {}};
  r.correlation = correlation;
  r.size = size;
  r.record = record_advice(p.effect.type, type);
  p.rivals.push_back(std::move(r));
}

}  // namespace

std::vector<PlannedEffect> planned_scatter(const PlannedRecord& record, const Sight& sight,
                                           const PlanOptions& options) {
  const Evidence& e = record.evidence;
  const Scattered s(record, sight, options);
  const double seen = s.seen(), noise_from = s.noise_from(), jitter_from = s.jitter_from();
  const Eigen::ArrayXd v2 = e.velocity.square();
  const auto mean = [&](const Eigen::ArrayXd& x) { return (record.weight * x).sum() / record.weight.sum(); };
  const double alike = mean(v2) / std::sqrt(std::max(mean(v2.square()), 1e-300));
  std::vector<PlannedEffect> list;
  list.push_back(planned("noise", e, "sigma", 1 / e.step(), seen, noise_from));
  add_rival(list.back(), "timing_jitter", noise_from * e.step(), alike);
  if (s.speed() > 0) {
    list.push_back(planned("timing_jitter", e, "sigma", s.speed(), seen, jitter_from));
    add_rival(list.back(), "noise", jitter_from / s.speed(), alike);
  }
  if (e.encoder.counts_per_period == 4)
    list.push_back(planned("state_width", e, "phase", 2 / std::numbers::pi, s.states(), 0));
  return list;
}

}  // namespace qerr
