#include "diagnose/inference/scatter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/probability.hpp"
#include "core/statistics.hpp"
#include "diagnose/inference/selection.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr double many_outliers = 0.06;  ///< fraction of the readings (convention)
constexpr const char* part_far_off = "part of the readings is far off";
constexpr double significant = 1e-3;  ///< p-value (convention)
/// Largest loss of log-likelihood of an alternative: half the 99.95 % quantile of chi-squared.
constexpr double indistinguishable = 6.05;
constexpr double correlated = 0.2;  ///< lag-one autocorrelation of the scores (convention)
// Smaller scatter is not tested for evenness: quantization, 0.29 counts, dominates the residual.
constexpr double uneven_from = 0.4;  ///< [counts]
// The reference's noise is an estimate. The null hypothesis has its variance times 1.69, the square of
// scatter_beyond_reference; displaced edges, which do not scatter, times 1.21: 10 % more noise (conventions).
constexpr double inflated_noise = 1.69, inflated_noise_of_states = 1.21;

/// Log-likelihood with a standard deviation for every reading.
double value(const Intervals& intervals, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma, double range) {
  return interval_likelihood(intervals, x, sigma, outlier_part, range).log_likelihood;
}

/// Argument and value of the maximum of a function over low .. high, on a logarithmic grid that is refined.
template <typename Function>
std::pair<double, double> largest(Function function, double low, double high) {
  double best = low, at_best = function(low);
  double step = std::log(high / low) / 12;
  for (double x = low * std::exp(step); x <= high * 1.0001; x *= std::exp(step))
    if (const double y = function(x); y > at_best) at_best = y, best = x;
  for (int i = 0; i < 5; ++i) {
    step /= 2;
    for (const double x : {best * std::exp(-step), best * std::exp(step)})
      if (const double y = function(x); y > at_best) at_best = y, best = x;
  }
  return {best, at_best};
}

/// Lag-one autocorrelation.
double lag_one(const Eigen::ArrayXd& s) {
  const Eigen::Index n = s.size() - 1;
  const double power = s.square().sum();
  return n > 0 && power > 0 ? (s.head(n) * s.tail(n)).sum() / power : 0;
}

/// Edges of odd number displaced by `shift`: edge k lies between the counts k - 1 and k.
Intervals displaced(const Intervals& ideal, const Evidence& e, double shift) {
  Intervals moved = ideal;
  for (Eigen::Index i = 0; i < e.rows(); ++i) {
    const bool odd = std::fmod(std::abs(std::round(e.measured[i] / e.step())), 2) == 1;
    (odd ? moved.lower : moved.upper)[i] += shift;
  }
  return moved;
}

/// Size of the largest outlier, a residual that neither the terms nor the scatter of the other readings
/// explain; 0 without outliers.
double farthest(const Evidence& e, const Explanation& m, const Eigen::ArrayXd& added) {
  const double shape = 3 * added.abs().maxCoeff() + 5 * e.step() + 8 * e.noise;
  const Eigen::ArrayXd possible = (8 * m.plain_noise() / m.noise() * m.scatter()).max(shape);
  const Eigen::ArrayXd off = (e.measured - e.path - m.addition()).abs();
  return (off > possible).any() ? off.maxCoeff() : 0;
}

struct ScatterCandidate {
  Effect effect;
  double value = 0;
  double relative_error = 0;
  Eigen::ArrayXd added = {};  ///< variance that it adds to every row; empty: it displaces edges
};

/// Half-width of the 95 % interval of a positive parameter relative to its estimate, from the curvature of
/// the log-likelihood in the parameter's logarithm at the maximum.
template <typename Function>
double relative_error(Function function, double best, double at_best) {
  constexpr double step = 0.05;
  const double curvature =
      (2 * at_best - function(best * std::exp(step)) - function(best * std::exp(-step))) / (step * step);
  return curvature > 0 ? std::min(1.0, 1.96 / std::sqrt(curvature)) : 1;
}

/// Whether the residual's variance over the expected one differs by more than 3 between twelfths of the rows,
/// sorted by `along`.
bool is_uneven(const Eigen::ArrayXd& squares, const Eigen::ArrayXd& variance, const Eigen::ArrayXd& along) {
  constexpr Eigen::Index parts = 12, fewest = 40;  // rows per part at least (convention)
  constexpr double largest_ratio = 3;
  const Eigen::Index n = squares.size();
  if (n < parts * fewest) return false;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return along[a] < along[b]; });
  double least = 1e300, most = 0;
  for (Eigen::Index i = 0; i < parts; ++i) {
    double observed = 0, expected = 0;
    for (Eigen::Index k = i * n / parts; k < (i + 1) * n / parts; ++k) {
      observed += squares[order[static_cast<std::size_t>(k)]];
      expected += variance[order[static_cast<std::size_t>(k)]];
    }
    least = std::min(least, observed / expected);
    most = std::max(most, observed / expected);
  }
  return most > largest_ratio * least;
}

/// Effects that could scatter the readings of a fitted model, each at its most likely size.
class Trials {
 public:
  /// @param own   residual noise of the reference [rad or m]
  /// @param size  of the scatter in excess of it [rad or m]
  Trials(const Evidence& e, const Explanation& m, double own, double size)
      : e_(e),
        m_(m),
        size_(size),
        range_(2 * (e.measured - e.reference).abs().maxCoeff() + e.step()),
        known_((own * m.scatter() / m.noise()).square()) {}

  /// Variance of every row due to the reference's residual noise and the spec's random effects.
  const Eigen::ArrayXd& known() const { return known_; }

  /// Likelihood with the known variance alone.
  IntervalLikelihood without() const {
    return interval_likelihood(m_.intervals(), m_.addition(), (inflated_noise * known_).sqrt(), outlier_part,
                               range_);
  }

  /// In descending order of likelihood.
  std::vector<ScatterCandidate> candidates() const {
    std::vector<ScatterCandidate> found;
    for (const EffectKind& kind : effect_kinds()) {
      if (!kind.scattering || (kind.scattering->possible && !kind.scattering->possible(e_))) continue;
      if (kind.random())
        found.push_back(random(kind));
      else
        for (const double sign : {-1.0, 1.0}) found.push_back(displaced_edges(kind, sign));
    }
    std::sort(found.begin(), found.end(),
              [](const ScatterCandidate& a, const ScatterCandidate& b) { return a.value > b.value; });
    return found;
  }

 private:
  Effect effect(const EffectKind& kind, double size) const {
    return {std::string(kind.name), e_.joint, {{std::string(kind.scattering->parameter), size}}, {}};
  }

  ScatterCandidate random(const EffectKind& kind) const {
    const Eigen::ArrayXd deviation = kind.scattering->deviation(e_);
    const auto with = [&](double x) {
      return value(m_.intervals(), m_.addition(), (known_ + (x * deviation).square()).sqrt(), range_);
    };
    // A uniform scatter has the size of the residual's; any other may be concentrated in few rows.
    const double typical = rms(deviation), factor = kind.scattering->uniform ? 3 : 10;
    const double low = kind.scattering->uniform ? 0.3 : 0.1;
    const auto [size, best] = largest(with, low * size_ / typical, factor * size_ / typical);
    return {effect(kind, size), best, relative_error(with, size, best), (size * deviation).square()};
  }

  /// @param sign  direction in which every second edge is displaced
  ScatterCandidate displaced_edges(const EffectKind& kind, double sign) const {
    const auto with = [&](double x) {
      // The mean of displaced edges is -shift/2, which an offset term may include.
      const Eigen::ArrayXd centred = m_.addition() - m_.mean_offset();
      return value(displaced(m_.intervals(), e_, sign * x), centred,
                   (inflated_noise_of_states * known_).sqrt(), range_);
    };
    const auto [shift, best] = largest(with, 0.02 * e_.step(), 0.95 * e_.step());
    return {effect(kind, kind.scattering->of_displacement(sign * shift, e_.encoder)), best,
            relative_error(with, shift, best)};
  }

  const Evidence& e_;
  const Explanation& m_;
  double size_, range_;
  Eigen::ArrayXd known_;
};

/// Whether the residual scatters differently from a candidate's variance over the position or over time.
bool is_uneven(const Evidence& e, const Explanation& m, const Eigen::ArrayXd& known,
               const ScatterCandidate& c) {
  const Eigen::ArrayXd squares = (e.measured - e.reference - m.addition()).square();
  const Eigen::ArrayXd variance = e.step() * e.step() / 12 + known + c.added;
  return is_uneven(squares, variance, e.path) || (e.ordered && is_uneven(squares, variance, e.time));
}

/// Whether the scatter is due to outliers; if so, sets its structure and size.
bool has_outliers(const Evidence& e, const Explanation& m, const Eigen::ArrayXd& added, Scatter& s) {
  if (const double off = farthest(e, m, added); off > 0) {
    s.size = off;
    s.structure = "single readings are far off";
    return true;
  }
  if (m.outliers() <= many_outliers) return false;
  s.size = std::sqrt(mean_square_residual(m, e));
  s.structure = part_far_off;
  return true;
}

/// Identifies the scatter with the most likely candidate, if that is significant and the residual has no
/// other structure.
void name_scatter(const Evidence& e, const Explanation& m, const Trials& trials, Scatter& s) {
  const IntervalLikelihood without = trials.without();
  const std::vector<ScatterCandidate> found = trials.candidates();
  const ScatterCandidate& best = found[0];
  const double ratio = 2 * (best.value - without.log_likelihood);
  if (ratio <= 0) {
    if (without.outliers > many_outliers * static_cast<double>(e.rows())) s.structure = part_far_off;
    return;
  }
  s.p_value = chi_squared_tail(ratio, 1);
  if (s.p_value * static_cast<double>(found.size()) > significant) return;
  // A correlated residual is neither noise nor jitter; unequal states depend on the count.
  if (!s.structure.empty() && best.added.size() > 0) return;
  s.structure.clear();
  if (best.added.size() > 0 && s.size > uneven_from * e.step() && is_uneven(e, m, trials.known(), best)) {
    s.structure = "scatter of varying size";
    return;
  }
  s.effect = best.effect;
  s.relative_error = best.relative_error;
  for (const ScatterCandidate& other : found)
    if (other.effect.type != s.effect->type && best.value - other.value < indistinguishable) {
      s.alternative = other.effect;
      break;
    }
}

}  // namespace

Scatter scatter_of(const Evidence& e, const Explanation& m) {
  Scatter s;
  const double own = std::max(e.path_noise, 1e-3 * e.step());
  s.size = std::sqrt(std::max(0.0, m.noise() * m.noise() - own * own));
  const Eigen::ArrayXd added = m.addition() - m.addition().mean();
  if (has_outliers(e, m, added, s)) return s;
  // Ignore scatter below 1/12 of the explained rms (convention): the error of the terms' shapes.
  const double worth = std::max(scatter_worth_naming * e.step(), rms(added) / 12);
  if (m.noise() < scatter_beyond_reference * own || s.size < worth) return s;
  if (lag_one(m.likelihood().score) > correlated) s.structure = "structure without a period or a known shape";
  name_scatter(e, m, Trials(e, m, own, s.size), s);
  return s;
}

}  // namespace qerr
