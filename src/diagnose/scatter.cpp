#include "scatter.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

constexpr double outlier_part = 0.01;
constexpr double worth_naming = 0.06;  ///< [counts]
constexpr double correlated = 0.2;     ///< of neighbouring scores

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

struct Candidate {
  Effect effect;
  double value = 0;
};

}  // namespace

Scatter scatter_of(const Evidence& e, const Explanation& m) {
  Scatter s;
  const double range = 2 * (e.measured - e.reference).abs().maxCoeff() + e.step();
  const double own = std::max({e.noise, 0.3 * e.grid, 1e-3 * e.step()});
  const double beyond = m.noise() * m.noise() - own * own;
  s.size = std::sqrt(std::max(0.0, beyond));
  s.structured = lag_one(m.likelihood().score) > correlated;
  if (m.noise() < 1.3 * own || s.size < worth_naming * e.step()) return s;
  // What the reference and the spec's own random effects leave to chance already.
  const Eigen::ArrayXd known = (own * m.scatter() / m.noise()).square();
  // The reference's noise is an estimate: a third more of it would be no find.
  const double none = value(m.intervals(), m.addition(), (1.69 * known).sqrt(), range);
  std::vector<Candidate> found;
  const auto [noise, at_noise] =
      largest([&](double x) { return value(m.intervals(), m.addition(), (known + x * x).sqrt(), range); },
              0.3 * s.size, 3 * s.size);
  found.push_back({{"noise", e.joint, {{"sigma", noise}}, {}}, at_noise});
  if (e.ordered && e.velocity.abs().maxCoeff() > 0) {
    const double typical = std::sqrt(e.velocity.square().mean());
    const auto [jitter, at_jitter] = largest(
        [&](double x) {
          return value(m.intervals(), m.addition(), (known + (x * e.velocity).square()).sqrt(), range);
        },
        0.1 * s.size / typical, 10 * s.size / typical);
    found.push_back({{"timing_jitter", e.joint, {{"sigma", jitter}}, {}}, at_jitter});
  }
  if (e.counted && e.encoder.counts_per_period == 4) {
    for (const double sign : {-1.0, 1.0}) {
      const auto [shift, at_shift] = largest(
          [&](double x) {
            // Their mean is -shift/2, which a term for the offset may have taken.
            const Eigen::ArrayXd at = m.addition() - m.mean_offset();
            return value(displaced(m.intervals(), e, sign * x), at, (1.21 * known).sqrt(), range);
          },
          0.02 * e.step(), 0.95 * e.step());
      const double phase = sign * shift / (4 * e.step()) * 2 * std::numbers::pi;
      found.push_back({{"state_width", e.joint, {{"phase", phase}}, {}}, at_shift});
    }
  }
  std::sort(found.begin(), found.end(),
            [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
  const double ratio = 2 * (found[0].value - none);
  if (ratio <= 0) return s;
  s.p_value = cdf(complement(boost::math::chi_squared(1), ratio));
  // What is correlated is neither noise nor jitter; unequal states are locked to the count.
  if (s.structured && found[0].effect.type != "state_width") return s;
  s.structured = false;
  s.effect = found[0].effect;
  for (const Candidate& other : found)
    if (other.effect.type != s.effect->type && found[0].value - other.value < 6) {
      s.alternative = other.effect;
      break;
    }
  return s;
}

}  // namespace qerr
