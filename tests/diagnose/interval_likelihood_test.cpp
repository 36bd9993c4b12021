#include "diagnose/inference/interval_likelihood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/random_chain.hpp"

/// The likelihood of single readings against its definition, in long double: exp(-150^2/2) is still a number.
namespace qerr {
namespace {

using testing::Dice;
using Extended = long double;

Extended upper_tail(Extended z) { return 0.5L * std::erfc(z / std::numbers::sqrt2_v<Extended>); }
Extended gaussian_density(Extended z) {
  return std::exp(-0.5L * z * z) / std::sqrt(2 * std::numbers::pi_v<Extended>);
}

/// Phi(b) - Phi(a) from the tail that is no difference of nearly equal numbers.
Extended normal_probability(Extended a, Extended b) {
  return a > 0 ? upper_tail(a) - upper_tail(b) : upper_tail(-b) - upper_tail(-a);
}

struct SingleReading {
  double lower, upper, x, sigma, outliers, spread;
};

struct LikelihoodByDefinition {
  Extended value, inlier, score, curvature, cross, scale_score, scale_curvature;
};

/// By the definitions of interval_likelihood.hpp, with u = x and w = 1: P = Phi(B w - u/sigma) - ...
LikelihoodByDefinition likelihood_by_definition(const SingleReading& r) {
  const Extended s = r.sigma, l = r.lower / s, u = r.upper / s, a = l - r.x / s, b = u - r.x / s;
  const Extended p = normal_probability(a, b),
                 other = r.outliers * std::min<Extended>(1, (u - l) * s / r.spread);
  const Extended at_a = gaussian_density(a) / p, at_b = gaussian_density(b) / p;
  LikelihoodByDefinition e{};
  e.value = std::log((1 - r.outliers) * p + other);
  e.inlier = (1 - r.outliers) * p / ((1 - r.outliers) * p + other);
  // d log P = P'/P, d^2 log P = P''/P - (P'/P)^2, with phi' = -z phi.
  const Extended du = at_a - at_b, dw = u * at_b - l * at_a;
  const Extended duu = a * at_a - b * at_b, dww = l * l * a * at_a - u * u * b * at_b,
                 duw = u * b * at_b - l * a * at_a;
  e.score = e.inlier * du / s;
  e.curvature = -e.inlier * (duu - du * du) / (s * s);
  e.cross = -e.inlier * (duw - du * dw) / s;
  e.scale_score = e.inlier * dw;
  e.scale_curvature = -e.inlier * (dww - dw * dw);
  return e;
}

void expect_within(double value, Extended expected, Extended tolerance, const char* what,
                   const SingleReading& r) {
  EXPECT_NEAR(value, static_cast<double>(expected), static_cast<double>(tolerance))
      << what << " of " << r.lower << " .. " << r.upper << " at " << r.x << ", sigma " << r.sigma
      << ", outliers " << r.outliers << ", spread " << r.spread;
}

TEST(IntervalLikelihood, IsThatOfItsDefinitionForReadingsOfAllKinds) {
  Dice dice(17);
  for (int i = 0; i < 8000; ++i) {
    SingleReading r{};
    r.sigma = std::pow(10, dice.between(-1.5, 1.5));
    r.lower = dice.between(-3, 3);
    r.upper = r.lower + std::pow(10, dice.between(-2, 1));
    // From within the interval to far beyond, on either side.
    const double away = std::pow(10, dice.between(-2, 1.7)) * r.sigma;
    const bool above = dice.chance(0.5);
    r.x = dice.chance(0.2) ? dice.between(r.lower, r.upper) : above ? r.upper + away : r.lower - away;
    // Of all sizes: those of fits, and such that a reading beyond 20 sigma may be either.
    const double power = dice.between(-110, -80), part = dice.between(1e-3, 0.2);
    r.outliers = dice.chance(0.4) ? 0 : dice.chance(0.5) ? part : std::pow(10, power);
    r.spread = std::pow(10, dice.between(-1, 2));
    const Intervals edges{Eigen::ArrayXd::Constant(1, r.lower), Eigen::ArrayXd::Constant(1, r.upper)};
    const IntervalLikelihood got = interval_likelihood(
        edges, Eigen::ArrayXd::Constant(1, r.x), Eigen::ArrayXd::Constant(1, r.sigma), r.outliers, r.spread);
    const LikelihoodByDefinition e = likelihood_by_definition(r);
    // Rounding errors of z = (edge - x)/sigma enter by z^2/2 and by the differences of narrow intervals;
    // beyond 20 sigma the series of the tail ends.
    const Extended s = r.sigma, reach = 1 + (std::abs(r.x) + std::abs(r.lower) + std::abs(r.upper)) / s;
    const Extended z = std::max((r.lower - r.x) / s, (r.x - r.upper) / s),
                   narrow = 1 + s / (r.upper - r.lower);
    const Extended relative =
        1e-14L * reach * reach * narrow * narrow + (z > 19.9L ? 105 / std::pow(z, 8.0L) : 0);
    const Extended twice = reach * reach * (1 + z * z * (z > 19.9L ? 1 : 0));
    const bool certain = (r.x - r.lower) / r.sigma > 8.5 && (r.upper - r.x) / r.sigma > 8.5;
    if (certain) {  // no outlier can be told: between the two probabilities
      EXPECT_GE(got.log_likelihood, std::log1p(-r.outliers) - 1e-12);
      EXPECT_LE(got.log_likelihood, static_cast<double>(e.value) + 1e-12);
      for (const double zero :
           {got.score[0], got.curvature[0], got.cross[0], got.scale_score, got.scale_curvature})
        EXPECT_EQ(zero, 0);
      continue;
    }
    expect_within(got.log_likelihood, e.value, relative, "value", r);
    expect_within(got.outliers, 1 - e.inlier, relative, "outliers", r);
    expect_within(got.score[0], e.score, relative * reach / s, "score", r);
    expect_within(got.curvature[0], e.curvature, relative * twice / (s * s), "curvature", r);
    expect_within(got.cross[0], e.cross, relative * twice / s, "cross", r);
    expect_within(got.scale_score, e.scale_score, relative * twice, "scale score", r);
    expect_within(got.scale_curvature, e.scale_curvature, relative * twice, "scale curvature", r);
  }
}

TEST(IntervalLikelihood, SumsReadingsOfOneSigmaOrOfTheirOwn) {
  Dice dice(18);
  constexpr Eigen::Index n = 40;
  Intervals edges{Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
  Eigen::ArrayXd x(n), sigma(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    edges.lower[k] = dice.between(-2, 1);
    edges.upper[k] = edges.lower[k] + dice.between(0.1, 2);
    x[k] = dice.between(-2, 2);
    sigma[k] = dice.between(0.05, 1);
  }
  for (const bool same : {false, true}) {
    const Eigen::ArrayXd given = same ? Eigen::ArrayXd(sigma.head(1)) : sigma;
    const IntervalLikelihood all = interval_likelihood(edges, x, given, 0.05, 3);
    double value = 0, outliers = 0, scale_score = 0, scale_curvature = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      const Intervals one{edges.lower.segment(k, 1), edges.upper.segment(k, 1)};
      const IntervalLikelihood l =
          interval_likelihood(one, x.segment(k, 1), sigma.segment(same ? 0 : k, 1), 0.05, 3);
      value += l.log_likelihood;
      outliers += l.outliers;
      scale_score += l.scale_score;
      scale_curvature += l.scale_curvature;
      EXPECT_EQ(all.score[k], l.score[0]);
      EXPECT_EQ(all.curvature[k], l.curvature[0]);
      EXPECT_EQ(all.cross[k], l.cross[0]);
    }
    EXPECT_NEAR(all.log_likelihood, value, 1e-9);
    EXPECT_NEAR(all.outliers, outliers, 1e-9);
    EXPECT_NEAR(all.scale_score, scale_score, 1e-9 * (1 + std::abs(scale_score)));
    EXPECT_NEAR(all.scale_curvature, scale_curvature, 1e-9 * (1 + std::abs(scale_curvature)));
  }
}

}  // namespace
}  // namespace qerr
