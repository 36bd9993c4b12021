#include "qerr/bound/velocity_estimators.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
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

/// The effect of a spec on the joint `j`.
Effect effect_of(const std::string& type, std::map<std::string, double> numbers) {
  return {type, "j", std::move(numbers), {}};
}

Encoder encoder_of(double counts_per_period) {
  Encoder e;
  e.resolution = delta;
  e.counts_per_period = counts_per_period;
  return e;
}

TEST(EdgeErrors, AreThoseOfTheEffects) {
  EXPECT_TRUE(edge_errors(encoder_of(4), {}, "j").ideal());
  EXPECT_TRUE(edge_errors(encoder_of(4), {effect_of("state_width", {{"phase", 0.3}})}, "other").ideal());
  // A phase p displaces every second edge by 4 p/(2 pi) counts.
  const double s = 4 * 0.3 / (2 * std::numbers::pi);
  const EdgeErrors states = edge_errors(encoder_of(4), {effect_of("state_width", {{"phase", 0.3}})}, "j");
  EXPECT_NEAR(states.shortest, 1 - s, 1e-9);
  EXPECT_NEAR(states.longest, 1 + s, 1e-9);
  EXPECT_NEAR(states.spread, s, 1e-9);
  // An offset o of the sine displaces by o cos(angle) of 1/(2 pi) periods, to first order.
  const EdgeErrors offset =
      edge_errors(encoder_of(256), {effect_of("subdivision_error", {{"offset_sin", 0.01}})}, "j");
  EXPECT_NEAR(offset.longest - 1, 0.01, 5e-4);
  EXPECT_NEAR(offset.spread, 2 * 0.01 * 256 / (2 * std::numbers::pi), 1e-2);
  const EdgeErrors disc =
      edge_errors(encoder_of(4), {effect_of("eccentricity", {{"amplitude", 2e-3}, {"order", 1}})}, "j");
  EXPECT_NEAR(disc.slope, 2e-3, 1e-7);
  EXPECT_NEAR(disc.longest, 1 / (1 - 2e-3), 1e-7);
}

TEST(EstimatorErrors, WithUnequalEdgesDominateThoseOfAnEventDrivenSimulation) {
  const double s = 0.23;  // displacement of every second edge [counts]
  EdgeErrors edges{1 - s, 1 + s, s, 0};
  const auto edge = [&](double k) { return k + (std::fmod(std::abs(k), 2) == 1 ? s : 0); };
  for (int i = 0; i < 40; ++i) {
    const double v = 0.013 * std::pow(1.2, i);  // counts per tick of either clock
    const EstimatorError fdm = finite_difference_error(delta, rate, v * unit, edges),
                         itm = inverse_time_error(delta, rate, v * unit, edges);
    double of_difference = 0, of_interval = 0;
    for (int start = 0; start < 3000; ++start) {
      const double begin = 2 * uniform(static_cast<std::uint64_t>(start), 3),
                   clock = uniform(static_cast<std::uint64_t>(start), 4);
      const auto count = [&](double x) {
        double k = std::floor(x) + 2;
        while (edge(k) > x) --k;
        return k;
      };
      of_difference = std::max(of_difference, std::abs(count(begin + v) - count(begin) - v));
      for (const double k : {2.0, 3.0}) {
        const double from = edge(k) / v + clock, to = edge(k + 1) / v + clock,
                     ticks = std::ceil(to) - std::ceil(from);
        if (std::isfinite(itm.constant)) of_interval = std::max(of_interval, std::abs(1 / ticks - v));
      }
    }
    EXPECT_LE(of_difference * unit, fdm.constant * (1 + 1e-9)) << v;
    EXPECT_LE(of_interval * unit, itm.constant * (1 + 1e-9)) << v;
    EXPECT_LE(fdm.constant, fdm.varying * (1 + 1e-9)) << v;
    EXPECT_LE(itm.constant, itm.varying * (1 + 1e-9)) << v;
    if (std::isfinite(itm.constant)) {
      EXPECT_GE(of_interval * unit, 0.9 * itm.constant) << v;
    }
    EXPECT_GE(itm.varying, s * v * unit) << "the disc's own part, at every speed";
  }
}

TEST(EstimatorCrossing, OfUnequalEdgesIsWhereTheBoundsCrossOver) {
  const EdgeErrors edges{0.8, 1.2, 0.2, 1e-3};
  for (const double clock : {1000., 6000., 1e6}) {
    const double v = estimator_crossing(delta, rate, clock, edges);
    EXPECT_LE(inverse_time_error(delta, clock, 0.999 * v, edges).varying,
              finite_difference_error(delta, rate, 0.999 * v, edges).varying);
    EXPECT_GT(inverse_time_error(delta, clock, 1.001 * v, edges).varying,
              finite_difference_error(delta, rate, 1.001 * v, edges).varying);
    EXPECT_LT(v, estimator_crossing(delta, rate, clock));
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
