#include "interval_likelihood.hpp"

#include <cmath>
#include <numbers>

namespace qerr {

namespace {

constexpr double certain = 8.5;
constexpr double log_root_two_pi = 0.91893853320467274178;

/// log of the Gaussian's tail beyond z.
double log_tail(double z) {
  if (z < 20) return std::log(0.5 * std::erfc(z / std::numbers::sqrt2));
  const double r = 1 / (z * z);
  return -0.5 * z * z - std::log(z) - log_root_two_pi + std::log1p(-r * (1 - r * (3 - 15 * r)));
}

/// log(Phi(b) - Phi(a)), a < b, by the tail on the side where both lie.
double log_between(double a, double b) {
  if (a + b < 0) {
    const double mirrored = -a;
    a = -b;
    b = mirrored;
  }
  if (a <= 0) {
    const double inside =
        1 - 0.5 * (std::erfc(-a / std::numbers::sqrt2) + std::erfc(b / std::numbers::sqrt2));
    return std::log(std::max(inside, 1e-300));
  }
  const double near = log_tail(a), far = log_tail(b);
  return near + std::log1p(-std::exp(far - near));
}

double density_over(double z, double log_p) { return std::exp(-0.5 * z * z - log_root_two_pi - log_p); }

}  // namespace

IntervalLikelihood interval_likelihood(const Intervals& intervals, const Eigen::ArrayXd& x,
                                       const Eigen::ArrayXd& sigma, double outliers, double spread) {
  IntervalLikelihood l;
  l.score.setZero(x.size());
  l.curvature.setZero(x.size());
  l.cross.setZero(x.size());
  const double log_kept = std::log1p(-outliers);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double s = sigma[sigma.size() == 1 ? 0 : k];
    const double lower = intervals.lower[k] / s, upper = intervals.upper[k] / s;
    const double a = lower - x[k] / s, b = upper - x[k] / s;
    if (a < -certain && b > certain) {  // well inside: P = 1 to the last bit
      l.log_likelihood += log_kept;
      continue;
    }
    const double log_p = log_between(a, b);
    double kept = 1, log_mixed = log_p;
    if (outliers > 0) {
      const double log_other = std::log(outliers * std::min(1.0, (upper - lower) * s / spread));
      const double more = std::max(log_kept + log_p, log_other);
      log_mixed = more + std::log(std::exp(log_kept + log_p - more) + std::exp(log_other - more));
      kept = std::exp(log_kept + log_p - log_mixed);
    }
    l.outliers += 1 - kept;
    l.log_likelihood += log_mixed;
    const double at_a = density_over(a, log_p), at_b = density_over(b, log_p), both = at_a - at_b;
    l.score[k] = kept * both / s;
    l.curvature[k] = kept * std::max(0.0, both * both + b * at_b - a * at_a) / (s * s);
    l.scale_score += kept * (upper * at_b - lower * at_a);
    l.cross[k] = kept * (lower * at_a * (a - both) - upper * at_b * (b - both)) / s;
    l.scale_curvature += kept * (upper * upper * at_b * (b + at_b) - lower * lower * at_a * (a - at_a) -
                                 2 * lower * upper * at_a * at_b);
  }
  return l;
}

}  // namespace qerr
