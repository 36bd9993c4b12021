#include "diagnose/inference/interval_likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace qerr {

namespace {

/// Standard deviations beyond which Phi differs from 0 or 1 by less than half a unit in the last place of 1.
constexpr double certain = 8.5;
constexpr double log_root_two_pi = 0.91893853320467274178;

/// Standard deviations from the interval above which logarithms are used; exp(-20^2/2) does not underflow.
constexpr double far = 20;

/// log of the Gaussian's tail beyond z >= far.
double log_tail(double z) {
  const double r = 1 / (z * z);
  return -0.5 * z * z - std::log(z) - log_root_two_pi + std::log1p(-r * (1 - r * (3 - 15 * r)));
}

/// One reading: its log-likelihood, its probability of not being an outlier, and the Gaussian densities at
/// the edges over the Gaussian probability of the interval.
struct ReadingLikelihood {
  double log_likelihood, inlier, at_a, at_b;
};

/// Phi(b) - Phi(a), a < b, from the upper tail, mirrored if the interval is mainly below 0: no cancellation.
double between(double a, double b) {
  if (a + b < 0) a = -std::exchange(b, -a);
  const double above = std::erfc(b / std::numbers::sqrt2);
  const double twice =
      a <= 0 ? 2 - std::erfc(-a / std::numbers::sqrt2) - above : std::erfc(a / std::numbers::sqrt2) - above;
  return std::max(0.5 * twice, 1e-300);
}

/// @param other  probability of an outlier in the interval
ReadingLikelihood near_reading(double a, double b, double outliers, double other) {
  const double p = between(a, b), own = (1 - outliers) * p, total = own + other;
  const double over_p = std::exp(-log_root_two_pi) / p;
  return {std::log(total), own / total, std::exp(-0.5 * a * a) * over_p, std::exp(-0.5 * b * b) * over_p};
}

/// Likelihood of a reading far from its interval, in logarithms, which do not underflow.
ReadingLikelihood far_reading(double a, double b, double outliers, double other) {
  const double log_near = log_tail(std::max(a, -b)), log_beyond = log_tail(std::max(b, -a));
  const double log_p = log_near + std::log1p(-std::exp(log_beyond - log_near));
  const double own = std::log1p(-outliers) + log_p;
  const auto density = [&](double z) { return std::exp(-0.5 * z * z - log_root_two_pi - log_p); };
  if (outliers == 0) return {own, 1, density(a), density(b)};
  const double log_other = std::log(other), more = std::max(own, log_other);
  const double log_total = more + std::log(std::exp(own - more) + std::exp(log_other - more));
  return {log_total, std::exp(own - log_total), density(a), density(b)};
}

}  // namespace

IntervalLikelihood interval_likelihood(const Intervals& intervals, const Eigen::ArrayXd& x,
                                       const Eigen::ArrayXd& sigma, double outliers, double spread) {
  IntervalLikelihood l;
  l.score.setZero(x.size());
  l.curvature.setZero(x.size());
  l.cross.setZero(x.size());
  const double log_inlier = std::log1p(-outliers);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double s = sigma[sigma.size() == 1 ? 0 : k];
    const double lower = intervals.lower[k] / s, upper = intervals.upper[k] / s;
    const double a = lower - x[k] / s, b = upper - x[k] / s;
    if (a < -certain && b > certain) {  // P = 1 in double precision
      l.log_likelihood += log_inlier;
      continue;
    }
    const double other = outliers * std::min(1.0, (upper - lower) * s / spread);
    const auto [log_probability, inlier, at_a, at_b] =
        std::max(a, -b) < far ? near_reading(a, b, outliers, other) : far_reading(a, b, outliers, other);
    l.outliers += 1 - inlier;
    l.log_likelihood += log_probability;
    const double both = at_a - at_b;
    l.score[k] = inlier * both / s;
    l.curvature[k] = inlier * std::max(0.0, both * both + b * at_b - a * at_a) / (s * s);
    l.scale_score += inlier * (upper * at_b - lower * at_a);
    l.cross[k] = inlier * (lower * at_a * (a - both) - upper * at_b * (b - both)) / s;
    l.scale_curvature += inlier * (upper * upper * at_b * (b + at_b) - lower * lower * at_a * (a - at_a) -
                                   2 * lower * upper * at_a * at_b);
  }
  return l;
}

}  // namespace qerr
