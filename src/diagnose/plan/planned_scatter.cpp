#include "diagnose/plan/planned_scatter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/statistics.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/plan/identifiability.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Argument in [0.01, 100] at which an increasing function reaches a value, by bisection; infinite if larger.
double argument_of(const std::function<double(double)>& increasing, double value) {
  double low = 0.01, high = 100;
  if (increasing(high) < value) return std::numeric_limits<double>::infinity();
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

/// Sizes of random errors that a record of the planned motion shows beyond the noise of its reference.
class ScatterPower {
 public:
  ScatterPower(const PlannedRecord& r, const Identifiability& s, const PlanOptions& o)
      : own_(r.evidence.noise / r.evidence.step()),
        total_(s.information().log_sigma * s.readings()),
        position_(s.information().position * s.readings()),
        need_(noncentrality_for_power(2 * indistinguishable_loss, 1, o.power)) {}

  /// Smallest detectable rms [counts]: the estimate must exceed the thresholds of scatter_of with a one-sided
  /// probability of 95 %, the relative error of a standard deviation being 1/sqrt(information).
  double detectable() const {
    const double spread = 1 + 1.645 / std::sqrt(total_);
    const double ratio = std::max(scatter_beyond_reference * spread, std::exp(std::sqrt(need_ / total_)));
    return std::max(own_ * std::sqrt(ratio * ratio - 1), scatter_worth_naming * spread);
  }

  /// Smallest detectable displacement of every second edge [counts]. Its rms about the mean is half of it;
  /// the mean may be due to an offset.
  double detectable_displacement() const {
    return std::max(2 * detectable(), 2 * std::sqrt(need_ / position_));
  }

  double own() const { return own_; }      ///< noise of the reference [counts]
  double total() const { return total_; }  ///< information of all readings on log sigma
  double need() const { return need_; }    ///< noncentrality for the given power

 private:
  double own_, total_, position_, need_;
};

/// Random errors proportional to a quantity that varies from row to row, such as the velocity, compared with
/// uniform ones.
class VaryingScatter {
 public:
  /// @param deviation  of every row, per unit of the effect's parameter [rad or m]
  VaryingScatter(const PlannedRecord& r, const Eigen::ArrayXd& deviation, const ScatterPower& power)
      : power_(power) {
    const Eigen::ArrayXd d = deviation.abs() / r.evidence.step(), d2 = deviation.square();
    const auto mean = [&](const Eigen::ArrayXd& x) { return (r.weight * x).sum() / r.weight.sum(); };
    rms_ = std::sqrt(mean(d.square()));
    correlation_ = mean(d2) / std::sqrt(std::max(mean(d2.square()), 1e-300));
    // Histogram of the readings by deviation.
    constexpr Eigen::Index bins = 200;
    const double largest = d.maxCoeff();
    deviations_ = largest * Eigen::ArrayXd::LinSpaced(bins, 0, 1);
    weight_ = Eigen::ArrayXd::Zero(bins);
    for (Eigen::Index k = 0; k < d.size(); ++k)
      weight_[rms_ > 0 ? std::lround(d[k] / largest * (bins - 1)) : 0] += r.weight[k];
  }

  double rms() const { return rms_; }                  ///< per unit of the parameter [counts]
  double correlation() const { return correlation_; }  ///< of its variance with a uniform one

  /// Rms from which it is distinguished from a uniform scatter [counts].
  double varying_from() const {
    if (rms_ == 0) return std::numeric_limits<double>::infinity();
    return argument_of([&](double x) { return power_.total() * variance(log_sigma(x), weight_); },
                       power_.need());
  }

  /// Rms from which a uniform scatter is distinguished from this one [counts].
  double uniform_from() const {
    if (rms_ == 0) return std::numeric_limits<double>::infinity();
    const auto distance = [&](double x) {
      const double log_uniform = std::log(std::hypot(power_.own(), x));
      double least = std::numeric_limits<double>::infinity();
      for (double c = 0.25 * x; c < 4 * x; c *= 1.05)
        least = std::min(least, (weight_ * (log_sigma(c) - log_uniform).square()).sum());
      return power_.total() * least / weight_.sum();
    };
    return argument_of(distance, power_.need());
  }

 private:
  /// Logarithm of the scatter in every bin, when the effect adds an rms of x counts.
  Eigen::ArrayXd log_sigma(double x) const {
    return 0.5 * (power_.own() * power_.own() + (x / rms_ * deviations_).square()).log();
  }

  ScatterPower power_;
  double rms_ = 0, correlation_ = 0;
  Eigen::ArrayXd deviations_, weight_;  ///< [counts per unit], readings
};

PlannedEffect planned(const EffectKind& kind, const Evidence& e, double counts_per_size,
                      double detectable_counts) {
  PlannedEffect p;
  p.effect = {std::string(kind.name), e.joint, {}, {}};
  p.parameter = kind.scattering->parameter;
  p.counts_per_size = counts_per_size;
  p.detectable = p.identifiable = detectable_counts / counts_per_size;
  return p;
}

/// @param counts  rms from which the effect is distinguished from the other
void add_correlated(PlannedEffect& p, const EffectKind& other, double counts, double correlation) {
  CorrelatedEffect r;
  r.effect = {std::string(other.name), p.effect.joint, {}, {}};
  r.correlation = correlation;
  r.separable_from = counts / p.counts_per_size;
  r.record = record_advice(p.effect.type, other.name);
  p.identifiable = std::max(p.identifiable, r.separable_from);
  p.correlated.push_back(std::move(r));
}

}  // namespace

std::vector<PlannedEffect> planned_scatter(const PlannedRecord& record,
                                           const Identifiability& identifiability,
                                           const PlanOptions& options) {
  const Evidence& e = record.evidence;
  const ScatterPower power(record, identifiability, options);
  std::vector<const EffectKind*> uniform, varying, edges;
  for (const EffectKind& kind : effect_kinds())
    if (kind.scattering)
      (!kind.random() ? edges : kind.scattering->uniform ? uniform : varying).push_back(&kind);
  std::vector<PlannedEffect> list;
  for (const EffectKind* u : uniform) {
    list.push_back(planned(*u, e, rms(u->scattering->deviation(e)) / e.step(), power.detectable()));
    for (const EffectKind* v : varying) {
      const VaryingScatter scatter(record, v->scattering->deviation(e), power);
      add_correlated(list.back(), *v, scatter.uniform_from(), scatter.correlation());
    }
  }
  for (const EffectKind* v : varying) {
    if (v->scattering->possible && !v->scattering->possible(e)) continue;
    const VaryingScatter scatter(record, v->scattering->deviation(e), power);
    list.push_back(planned(*v, e, scatter.rms(), power.detectable()));
    for (const EffectKind* u : uniform)
      add_correlated(list.back(), *u, scatter.varying_from(), scatter.correlation());
  }
  for (const EffectKind* kind : edges)
    if (!kind->scattering->possible || kind->scattering->possible(e))
      list.push_back(planned(*kind, e, 1 / kind->scattering->of_displacement(e.step(), e.encoder),
                             power.detectable_displacement()));
  return list;
}

}  // namespace qerr
