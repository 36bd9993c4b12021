#include "qerr/bound/velocity_estimators.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/random.hpp"

namespace qerr {
namespace {

constexpr double delta = 1e-3, rate = 1000, unit = delta * rate;

double uniform(std::uint64_t index, std::uint64_t stream) {
  return unit_interval(random_bits(5, index, stream));
}

/// Largest error of finite differences along x(t), t in ticks, over many positions of the encoder's zero.
template <class Position>
double simulated_fdm(Position x, int samples) {
  double largest = 0;
  for (int zero = 0; zero < 200; ++zero)
    for (int k = 1; k <= samples; ++k) {
      const double shift = uniform(static_cast<std::uint64_t>(zero), 1);
      const double counts = std::floor(x(k) + shift) - std::floor(x(k - 1) + shift);
      largest = std::max(largest, std::abs(counts - (x(k) - x(k - 1))));
    }
  return largest * unit;
}

/// Largest error of one interval timed in ticks, over random times of its first edge; the joint needs tau
/// ticks for it.
double simulated_itm(double tau, int starts) {
  double largest = 0;
  for (int i = 0; i < starts; ++i) {
    const double begin = uniform(static_cast<std::uint64_t>(i), 2);
    const double ticks = std::ceil(begin + tau) - std::ceil(begin);
    largest = std::max(largest, std::abs(1 / ticks - 1 / tau));
  }
  return largest * unit;
}

TEST(FiniteDifference, ErrorAtConstantSpeedAttainsItsBound) {
  for (int i = 0; i < 60; ++i) {
    const double v = 0.05 * std::pow(1.13, i);
    const double bound = finite_difference_error(delta, rate, v * unit).constant;
    const double found = simulated_fdm([&](int k) { return k * v; }, 300);
    EXPECT_LE(found, bound * (1 + 1e-9)) << v;
    EXPECT_GE(found, 0.999 * bound) << v;
  }
}

TEST(FiniteDifference, ErrorOfAnyMotionIsBoundedByOneCountPerSampleAndNearlyAttainsIt) {
  const double found = simulated_fdm([](int k) { return 40 * std::sin(0.013 * k); }, 3000);
  EXPECT_LT(found, finite_difference_error(delta, rate, 0.52 * unit).varying);
  EXPECT_GT(found, 0.97 * unit);
}

TEST(FiniteDifference, IsExactAtIntegerCountsPerSample) {
  for (const double v : {0., 1., 2., 3., 10.})
    EXPECT_EQ(finite_difference_error(delta, rate, v * unit).constant, 0);
  EXPECT_EQ(finite_difference_error(0.1, 1000, 0.3 * 1000).constant, 0);
}

TEST(InverseTime, ErrorAtConstantSpeedAttainsItsBound) {
  for (int i = 0; i < 60; ++i) {
    const double alpha = 1.01 * std::pow(1.07, i);
    const double bound = inverse_time_error(delta, rate, unit / alpha).constant;
    const double found = simulated_itm(alpha, 3000);
    EXPECT_LE(found, bound * (1 + 1e-9)) << alpha;
    EXPECT_GE(found, 0.97 * bound) << alpha;
  }
}

TEST(InverseTime, ErrorOfMonotoneMotionAttainsItsBound) {
  // The joint accelerates or decelerates between edges with the largest speed of alpha: v(t) = v_max (1 - c
  // t/tau) covers the quantum in tau = alpha/(1 - c/2) ticks.
  for (const double alpha : {1.0, 1.5, 2.0, 3.7, 7.2, 12.9}) {
    const double bound = inverse_time_error(delta, rate, unit / alpha).varying;
    double found = 0;
    for (int i = 0; i <= 1000; ++i)
      found = std::max(found, simulated_itm(alpha / (1 - 0.5 * i / 1000.), 1000));
    EXPECT_LE(found, bound * (1 + 1e-9)) << alpha;
    EXPECT_GE(found, 0.97 * bound) << alpha;
  }
}

TEST(InverseTime, BoundsAreOrderedAndThePrintedOneIsTooLargeByAKnownFactor) {
  for (double v = 0.003; v <= 1; v *= 1.07) {
    const EstimatorError e = inverse_time_error(delta, rate, v * unit);
    EXPECT_LE(e.constant, e.varying);
    EXPECT_NEAR(e.printed / e.varying, std::floor(1 / v) + 1, 1e-9);
    EXPECT_EQ(inverse_time_error(delta, rate, -v * unit).varying, e.varying);
  }
  EXPECT_TRUE(std::isinf(inverse_time_error(delta, rate, 1.01 * unit).varying));
  EXPECT_EQ(inverse_time_error(delta, rate, 0).varying, 0);
  EXPECT_EQ(inverse_time_error(delta, rate, unit / 7).constant, 0);
}

TEST(EstimatorCrossing, IsWhereTheLeastBoundsCrossOver) {
  EXPECT_DOUBLE_EQ(estimator_crossing(delta, rate, rate), unit);
  for (const double clock : {100., 1000., 2000., 5999., 6000., 6001., 1e6, 1e8}) {
    const double v = estimator_crossing(delta, rate, clock);
    for (const double at : {0.01, 0.3, 0.9, 0.9999})
      EXPECT_LE(inverse_time_error(delta, clock, at * v).varying, unit * (1 + 1e-12)) << clock;
    EXPECT_GT(inverse_time_error(delta, clock, 1.0001 * v).varying, unit) << clock;
  }
}

TEST(WorstCaseSnr, OfThePrintedBoundsIsThatOfThePaper) {
  // Eqs. 49 and 53: with these bounds ITM does not outperform FDM between half a count and one count per
  // sample.
  for (const double v : {0.55, 0.7, 0.99})
    EXPECT_NEAR(worst_case_snr_db(v, inverse_time_error(1, 1, v).printed),
                worst_case_snr_db(v, finite_difference_error(1, 1, v).printed), 1e-12);
  for (double v = 0.01; v < 1; v *= 1.1)
    EXPECT_GT(worst_case_snr_db(v, inverse_time_error(1, 1, v).varying),
              worst_case_snr_db(v, finite_difference_error(1, 1, v).varying));
  EXPECT_NEAR(worst_case_snr_db(10, 1), 20, 1e-12);
  EXPECT_EQ(worst_case_snr_db(2, inverse_time_error(1, 1, 2).varying), -INFINITY);
}

}  // namespace
}  // namespace qerr
