#include "qerr/bound/coherence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "qerr/bound/noise_in_motion.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {
namespace {

/// Difference at 1 Hz, then one pole at a: quantizes two ramps and filters the weighted sum of their errors.
constexpr double pole = 0.8;
Filter filter() { return filter_from_coefficients({1 - pole, -(1 - pole)}, {1, -pole}, 1, 1); }

double simulated_sigma(const MovingEncoder& one, const MovingEncoder& two, double zero) {
  double before = 0, y = 0, sum = 0;
  constexpr int settled = 300, samples = 20000;
  for (int k = 0; k < settled + samples; ++k) {
    const auto error = [](double x) { return std::floor(x + 0.5) - x; };
    const double e = one.weight * error(0.11 + k * one.speed) + two.weight * error(zero + k * two.speed);
    y = (1 - pole) * (e - before) + pole * y;
    before = e;
    if (k >= settled) sum += y * y;
  }
  return std::sqrt(sum / samples);
}

struct Range {
  double lowest = 1e9, highest = 0, mean_square = 0;
};

Range over_zeros(const MovingEncoder& one, const MovingEncoder& two) {
  Range r;
  constexpr int zeros = 100;
  for (int i = 0; i < zeros; ++i) {
    const double s = simulated_sigma(one, two, 0.11 + (i + 0.0) / zeros);
    r.lowest = std::min(r.lowest, s);
    r.highest = std::max(r.highest, s);
    r.mean_square += s * s / zeros;
  }
  return r;
}

TEST(Coherence, RangeHoldsEveryRunAndItsUpperEndIsReached) {
  const Autocorrelation a = autocorrelation(filter());
  const double v = 0.1 * std::numbers::phi;
  const std::pair<MovingEncoder, MovingEncoder> pairs[] = {
      {{1, v}, {1, v}},     {{1, v}, {-0.7, v}},      {{1, v}, {1, 2 * v}},     {{1, v}, {1, v + 0.5}},
      {{1, v}, {2, 1 - v}}, {{1, 3 * v}, {1, 2 * v}}, {{1, v}, {1, v + 1. / 3}}};
  for (const auto& [one, two] : pairs) {
    const CoherentSigma c = coherent_sigma(a, std::vector{one, two});
    const Range r = over_zeros(one, two);
    EXPECT_EQ(c.coincidences.size(), 1u) << two.speed / v;
    EXPECT_NEAR(c.sigma / std::sqrt(r.mean_square), 1, 1e-3) << two.speed / v;
    EXPECT_LE(r.highest, c.highest * 1.001) << two.speed / v;
    EXPECT_GE(r.lowest, c.lowest * 0.999) << two.speed / v;
    // The upper end for a positive term (the sum in step), the lower one for a negative term.
    const bool reached = r.highest > 0.99 * c.highest || r.lowest < 1.01 * c.lowest;
    EXPECT_TRUE(reached) << two.speed / v << ": " << r.lowest << " .. " << r.highest << " in " << c.lowest
                         << " .. " << c.highest;
  }
}

TEST(Coherence, IsNoneBetweenUnrelatedSpeeds) {
  const std::vector<MovingEncoder> encoders{{1, 0.1 * std::numbers::phi}, {1.5, 0.1 * std::numbers::e}};
  const CoherentSigma c = coherent_sigma(autocorrelation(filter()), encoders);
  EXPECT_TRUE(c.coincidences.empty());
  EXPECT_EQ(c.lowest, c.highest);
  const Range r = over_zeros(encoders[0], encoders[1]);
  EXPECT_NEAR(r.lowest / c.sigma, 1, 5e-3);
  EXPECT_NEAR(r.highest / c.sigma, 1, 5e-3);
}

TEST(Coherence, OfEncodersAtCommonFractionsIsAtMostFull) {
  // Every harmonic of one meets many of the other: only Cauchy and Schwarz bound the sum.
  const std::vector<MovingEncoder> encoders{{1, 0.25}, {1, 0.75}};
  const CoherentSigma c = coherent_sigma(autocorrelation(filter()), encoders);
  EXPECT_GT(c.coincidences.size(), 1u);
  EXPECT_LE(c.highest, std::sqrt(2.) * c.sigma * (1 + 1e-12));
  const Range r = over_zeros(encoders[0], encoders[1]);
  EXPECT_LE(r.highest, c.highest * 1.001);
}

TEST(Coherence, OfRestingEncodersIsNothing) {
  const CoherentSigma c =
      coherent_sigma(autocorrelation(filter()), std::vector<MovingEncoder>{{1, 0}, {1, 0}, {1, 2}});
  EXPECT_TRUE(c.coincidences.empty());
  EXPECT_EQ(c.highest, 0);
}

}  // namespace
}  // namespace qerr
