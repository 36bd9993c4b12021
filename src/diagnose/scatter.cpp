#include "scatter.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "model_choice.hpp"

namespace qerr {

namespace {

constexpr double many_outliers = 0.06;
constexpr double significant = 1e-3;
constexpr double correlated = 0.2;  ///< of neighbouring scores

/// Log-likelihood with a scatter of its own for every reading.
double value(const Intervals& intervals, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma, double range) {
  return interval_likelihood(intervals, x, sigma, outlier_part, range).log_likelihood;
}

/// The largest value of a function of a positive number, on a logarithmic grid that is refined.
template <typename Function>
std::pair<double, double> largest(Function function, double low, double high) {
  double best = low, at_best = function(low);
  double step = std::log(high / low) / 12;
  for (double x = low * std::exp(step); x <= high * 1.0001; x *= std::exp(step))
    if (const double here = function(x); here > at_best) at_best = here, best = x;
  for (int i = 0; i < 5; ++i) {
    step /= 2;
    for (const double x : {best * std::exp(-step), best * std::exp(step)})
      if (const double here = function(x); here > at_best) at_best = here, best = x;
  }
  return {best, at_best};
}

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

/// The largest residual of readings that neither the causes nor the scatter of the others can have made: a
/// glitch of the line. 0: there is none.
double farthest(const Evidence& e, const Explanation& m, const Eigen::ArrayXd& added) {
  const double shape = 3 * added.abs().maxCoeff() + 5 * e.step() + 8 * e.noise;
  const Eigen::ArrayXd possible = (8 * m.plain_noise() / m.noise() * m.scatter()).max(shape);
  const Eigen::ArrayXd off = (e.measured - e.path - m.addition()).abs();
  return (off > possible).any() ? off.maxCoeff() : 0;
}

struct Candidate {
  Effect effect;
  double value = 0;
  double relative_error = 0;
  Eigen::ArrayXd added = {};  ///< variance that it adds to every row; empty: it has none of its own
};

/// Half the 95 % interval of a positive number by the bend of the log-likelihood at its best, as a part of
/// it.
template <typename Function>
double relative_error(Function function, double best, double at_best) {
  constexpr double step = 0.05;
  const double bend =
      (2 * at_best - function(best * std::exp(step)) - function(best * std::exp(-step))) / (step * step);
  return bend > 0 ? std::min(1.0, 1.96 / std::sqrt(bend)) : 1;
}

/// Whether what is left scatters much more in some stretch of the order given than a variance says.
bool comes_and_goes(const Eigen::ArrayXd& squares, const Eigen::ArrayXd& variance,
                    const Eigen::ArrayXd& along) {
  constexpr Eigen::Index stretches = 12, fewest = 40;
  constexpr double much = 3;
  const Eigen::Index n = squares.size();
  if (n < stretches * fewest) return false;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return along[a] < along[b]; });
  double least = 1e300, most = 0;
  for (Eigen::Index i = 0; i < stretches; ++i) {
    double seen = 0, expected = 0;
    for (Eigen::Index k = i * n / stretches; k < (i + 1) * n / stretches; ++k) {
      seen += squares[order[static_cast<std::size_t>(k)]];
      expected += variance[order[static_cast<std::size_t>(k)]];
    }
    least = std::min(least, seen / expected);
    most = std::max(most, seen / expected);
  }
  return most > much * least;
}

}  // namespace

Scatter scatter_of(const Evidence& e, const Explanation& m) {
  Scatter s;
  const double range = 2 * (e.measured - e.reference).abs().maxCoeff() + e.step();
  const double own = std::max(e.path_noise, 1e-3 * e.step());
  const double beyond = m.noise() * m.noise() - own * own;
  s.size = std::sqrt(std::max(0.0, beyond));
  const Eigen::ArrayXd added = m.addition() - m.addition().mean();
  if (const double off = farthest(e, m, added); off > 0) {
    s.size = off;
    s.structure = "single readings are far off";
    return s;
  }
  if (m.outliers() > many_outliers) {
    s.size = std::sqrt(left_by(m, e));
    s.structure = "part of the readings is far off";
    return s;
  }
  // A twelfth of what the causes add may be what their shapes lack.
  const double worth = std::max(scatter_worth_naming * e.step(), std::sqrt(added.square().mean()) / 12);
  if (m.noise() < scatter_beyond_reference * own || s.size < worth) return s;
  if (lag_one(m.likelihood().score) > correlated) s.structure = "structure without a period or a known shape";
  // What the reference and the spec's own random effects leave to chance already.
  const Eigen::ArrayXd known = (own * m.scatter() / m.noise()).square();
  // The reference's noise is an estimate: a third more of it would be no find.
  const IntervalLikelihood without =
      interval_likelihood(m.intervals(), m.addition(), (1.69 * known).sqrt(), outlier_part, range);
  const double none = without.log_likelihood;
  std::vector<Candidate> found;
  const auto with_noise = [&](double x) {
    return value(m.intervals(), m.addition(), (known + x * x).sqrt(), range);
  };
  const auto [noise, at_noise] = largest(with_noise, 0.3 * s.size, 3 * s.size);
  found.push_back({{"noise", e.joint, {{"sigma", noise}}, {}},
                   at_noise,
                   relative_error(with_noise, noise, at_noise),
                   Eigen::ArrayXd::Constant(e.rows(), noise * noise)});
  if (e.ordered && e.velocity.abs().maxCoeff() > 0) {
    const double typical = std::sqrt(e.velocity.square().mean());
    const auto with_jitter = [&](double x) {
      return value(m.intervals(), m.addition(), (known + (x * e.velocity).square()).sqrt(), range);
    };
    const auto [jitter, at_jitter] = largest(with_jitter, 0.1 * s.size / typical, 10 * s.size / typical);
    found.push_back({{"timing_jitter", e.joint, {{"sigma", jitter}}, {}},
                     at_jitter,
                     relative_error(with_jitter, jitter, at_jitter),
                     (jitter * e.velocity).square()});
  }
  if (e.counted && !e.rests() && e.encoder.counts_per_period == 4) {
    for (const double sign : {-1.0, 1.0}) {
      const auto with_shift = [&](double x) {
        // Their mean is -shift/2, which a term for the offset may have taken.
        const Eigen::ArrayXd at = m.addition() - m.mean_offset();
        return value(displaced(m.intervals(), e, sign * x), at, (1.21 * known).sqrt(), range);
      };
      const auto [shift, at_shift] = largest(with_shift, 0.02 * e.step(), 0.95 * e.step());
      const double phase = sign * shift / (4 * e.step()) * 2 * std::numbers::pi;
      found.push_back({{"state_width", e.joint, {{"phase", phase}}, {}},
                       at_shift,
                       relative_error(with_shift, shift, at_shift)});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
  const double ratio = 2 * (found[0].value - none);
  if (ratio <= 0) {
    if (without.outliers > many_outliers * static_cast<double>(e.rows()))
      s.structure = "part of the readings is far off";
    return s;
  }
  s.p_value = cdf(complement(boost::math::chi_squared(1), ratio));
  if (s.p_value * static_cast<double>(found.size()) > significant) return s;
  // What is correlated is neither noise nor jitter; unequal states are locked to the count.
  if (!s.structure.empty() && found[0].effect.type != "state_width") return s;
  s.structure.clear();
  if (found[0].added.size() > 0 && s.size > 0.4 * e.step()) {
    const Eigen::ArrayXd squares = (e.measured - e.reference - m.addition()).square();
    const Eigen::ArrayXd variance = e.step() * e.step() / 12 + known + found[0].added;
    if (comes_and_goes(squares, variance, e.path) ||
        (e.ordered && comes_and_goes(squares, variance, e.time))) {
      s.structure = "scatter that comes and goes";
      return s;
    }
  }
  s.effect = found[0].effect;
  s.relative_error = found[0].relative_error;
  for (const Candidate& other : found)
    if (other.effect.type != s.effect->type && found[0].value - other.value < cannot_be_told) {
      s.alternative = other.effect;
      break;
    }
  return s;
}

}  // namespace qerr
