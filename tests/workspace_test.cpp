#include "qerr/bound/workspace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "qerr/filter/family.hpp"
#include "random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

constexpr double infinity = std::numeric_limits<double>::infinity();

Eigen::VectorXd at(double value) { return Eigen::VectorXd::Constant(1, value); }

Statistic statistic_of(const std::vector<double>& values, std::uint64_t expected = 0) {
  Accumulator a(expected);
  for (std::size_t i = 0; i < values.size(); ++i) a.add(values[i], at(static_cast<double>(i)));
  return a.result();
}

/// numpy.percentile(values, 100 p), method linear.
double exact_percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double position = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  if (below + 1 >= values.size()) return values.back();
  return values[below] + (position - static_cast<double>(below)) * (values[below + 1] - values[below]);
}

// Golden: numpy's definition in exact fractions; 1e-15 relative.
TEST(Statistic, PercentilesAreNumpysLinearOnes) {
  struct Case {
    std::vector<double> values;
    double p50, p95, p99, mean;
  };
  for (const Case& c :
       {Case{{3, 1, 2}, 2, 2.9, 2.98, 2}, Case{{4, 1, 3, 2}, 2.5, 3.85, 3.97, 2.5}, Case{{7}, 7, 7, 7, 7},
        Case{{0.5, 10, 2, 8, 2.5, 0, 1, 9, 100, 3, 4}, 3, 55, 91, 140.0 / 11}}) {
    const Statistic s = statistic_of(c.values);
    EXPECT_DOUBLE_EQ(s.p50, c.p50);
    EXPECT_DOUBLE_EQ(s.p95, c.p95);
    EXPECT_DOUBLE_EQ(s.p99, c.p99);
    EXPECT_DOUBLE_EQ(s.mean, c.mean);
    EXPECT_EQ(s.min, *std::min_element(c.values.begin(), c.values.end()));
    EXPECT_EQ(s.max, *std::max_element(c.values.begin(), c.values.end()));
  }
}

TEST(Statistic, BinnedPercentilesAreWithinTheirStatedError) {
  Dice dice(1);
  std::vector<double> values(200000);
  for (double& v : values) v = std::pow(10.0, dice.between(-30, 3));
  values.resize(values.size() + 1000, 0.0);
  const Statistic binned = statistic_of(values, Accumulator::exact_limit + 1);
  EXPECT_NEAR(binned.p50, exact_percentile(values, 0.50), 1.3e-4 * exact_percentile(values, 0.50));
  EXPECT_NEAR(binned.p95, exact_percentile(values, 0.95), 1.3e-4 * exact_percentile(values, 0.95));
  EXPECT_NEAR(binned.p99, exact_percentile(values, 0.99), 1.3e-4 * exact_percentile(values, 0.99));
  const Statistic exact = statistic_of(values);
  EXPECT_EQ(binned.mean, exact.mean);
  EXPECT_EQ(binned.max, exact.max);
  EXPECT_EQ(binned.min, 0);
  EXPECT_NE(binned.p50, exact.p50) << "bins were not in use";
}

TEST(Statistic, PercentilesAreExactUpToTheLimitAndSayWhenNot) {
  EXPECT_TRUE(Accumulator(Accumulator::exact_limit).percentiles_are_exact());
  EXPECT_FALSE(Accumulator(Accumulator::exact_limit + 1).percentiles_are_exact());
}

// Order statistics and extremes do not see how the values were cut and joined; the mean only by rounding
// (1e-14).
TEST(Statistic, AppendingGivesWhatAddingGives) {
  Dice dice(2);
  std::vector<double> values(999);
  for (double& v : values) v = dice.between(0, 1);
  for (const std::uint64_t expected : {std::uint64_t{0}, Accumulator::exact_limit + 1}) {
    const Statistic whole = statistic_of(values, expected);
    for (const std::size_t size : {1u, 10u, 998u}) {
      Accumulator joined(expected), backward(expected);
      std::vector<Accumulator> parts;
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % size == 0) parts.emplace_back(0);
        parts.back().add(values[i], at(static_cast<double>(i)));
      }
      for (const Accumulator& part : parts) joined.append(part);
      for (std::size_t i = parts.size(); i-- > 0;) backward.append(parts[i]);
      joined.append(Accumulator(0));
      for (const Statistic& s : {joined.result(), backward.result()}) {
        EXPECT_EQ(s.min, whole.min);
        EXPECT_EQ(s.max, whole.max);
        EXPECT_EQ(s.at_max, whole.at_max);
        EXPECT_EQ(s.p50, whole.p50);
        EXPECT_EQ(s.p95, whole.p95);
        EXPECT_EQ(s.p99, whole.p99);
        EXPECT_NEAR(s.mean, whole.mean, 1e-14);
      }
    }
  }
}

TEST(Statistic, NamesTheFirstConfigurationWithTheMaximum) {
  EXPECT_EQ(statistic_of({1, 5, 2, 5}).at_max, at(1));
  EXPECT_EQ(statistic_of({0, 0}).at_max, at(0));
  Accumulator a(0), b(0);
  a.add(5, at(1));
  b.add(5, at(2));
  a.append(b);
  EXPECT_EQ(a.result().at_max, at(1));
}

TEST(Statistic, InfinitiesStayInfinitiesAndNeverTurnIntoNaN) {
  for (const std::uint64_t expected : {std::uint64_t{0}, Accumulator::exact_limit + 1}) {
    const Statistic some = statistic_of({1, 2, infinity, 3, 4}, expected);
    EXPECT_EQ(some.max, infinity);
    EXPECT_EQ(some.mean, infinity);
    EXPECT_NEAR(some.p50, 3, 3 * 1.3e-4);
    EXPECT_EQ(some.p95, infinity);
    EXPECT_EQ(some.at_max, at(2));
    const Statistic all = statistic_of({infinity, infinity, infinity}, expected);
    for (const double value : {all.min, all.mean, all.max, all.p50, all.p95, all.p99})
      EXPECT_EQ(value, infinity);
    const Statistic none = statistic_of({0, 0, 0}, expected);
    for (const double value : {none.min, none.mean, none.max, none.p50, none.p99}) EXPECT_EQ(value, 0);
  }
}

OperationalModel random_model(std::uint64_t seed, bool nearest_only) {
  Dice dice(seed);
  OperationalModel m{make_chain(testing::random_robot(dice, {}), "", ""),
                     {},
                     {Coordinate::x, Coordinate::y, Coordinate::z, Coordinate::rz, Coordinate::roll}};
  m.transmission = testing::random_transmission(dice, m.chain, 1e-4, 1e-2, true);
  if (nearest_only)
    for (Encoder& encoder : m.transmission.encoders) encoder.rounding = Rounding::nearest;
  return m;
}

Configurations samples(const OperationalModel& m, std::uint64_t count) {
  Configurations c;
  c.count = count;
  c.ranges.assign(m.chain.independent.size(), Limits{-2, 2});
  return c;
}

std::vector<Norms> velocity() { return {norms(difference_filter(1000, 1))}; }

void expect_scaled(const Statistic& a, const Statistic& b, double factor) {
  for (const auto member : {&Statistic::min, &Statistic::mean, &Statistic::max, &Statistic::p50,
                            &Statistic::p95, &Statistic::p99})
    EXPECT_EQ(a.*member, factor * (b.*member));
  EXPECT_EQ(a.at_max, b.at_max);
}

void expect_scaled(const Workspace& a, const Workspace& b, double factor, bool rigorous) {
  EXPECT_EQ(a.count, b.count);
  for (std::size_t i = 0; i < b.coordinates.size(); ++i) {
    expect_scaled(a.coordinates[i].worst_case, b.coordinates[i].worst_case, factor);
    expect_scaled(a.coordinates[i].sigma, b.coordinates[i].sigma, factor);
    if (rigorous)
      expect_scaled(a.coordinates[i].worst_case_rigorous, b.coordinates[i].worst_case_rigorous, factor);
    EXPECT_EQ(a.coordinates[i].share, b.coordinates[i].share);
    EXPECT_EQ(a.coordinates[i].share_worst_case, b.coordinates[i].share_worst_case);
    expect_scaled(a.derivatives[0][i].worst_case, b.derivatives[0][i].worst_case, factor);
    expect_scaled(a.derivatives[0][i].sigma, b.derivatives[0][i].sigma, factor);
  }
  EXPECT_EQ(a.mean_variance_parts, factor * factor * b.mean_variance_parts);
  EXPECT_EQ(a.mean_covariance, factor * factor * b.mean_covariance);
  EXPECT_EQ(a.covariance_at_largest, factor * factor * b.covariance_at_largest);
  EXPECT_EQ(a.largest_at, b.largest_at);
  EXPECT_EQ(a.largest_arm, b.largest_arm);
  EXPECT_EQ(a.smallest_cosine_of_pitch, b.smallest_cosine_of_pitch);
}

TEST(Workspace, IsTheSameToTheLastBitForEveryNumberOfThreads) {
  for (const bool nearest_only : {true, false}) {
    const OperationalModel m = random_model(4, nearest_only);
    const Configurations c = samples(m, 3333);
    const Workspace one = workspace(m, velocity(), c, {1, {}, {}});
    for (const unsigned threads : {2u, 3u, 7u})
      expect_scaled(workspace(m, velocity(), c, {threads, {}, {}}), one, 1, true);
  }
}

// A half is exact in binary, so is everything that is linear in Delta.
TEST(Workspace, HalvingEveryResolutionHalvesEverythingLinear) {
  for (const bool nearest_only : {true, false}) {
    OperationalModel m = random_model(5, nearest_only);
    const Configurations c = samples(m, 700);
    const Workspace coarse = workspace(m, velocity(), c);
    for (Encoder& encoder : m.transmission.encoders) encoder.resolution /= 2;
    const Workspace fine = workspace(m, velocity(), c);
    expect_scaled(fine, coarse, 0.5, false);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LT(fine.coordinates[i].worst_case_rigorous.max,
                0.5 * coarse.coordinates[i].worst_case_rigorous.max);
      EXPECT_GE(fine.coordinates[i].worst_case_rigorous.max, fine.coordinates[i].worst_case.max);
    }
  }
}

// 1e-12: sums of 1000 shares.
TEST(Workspace, SharesSumToOneAndARowOfZerosHasNone) {
  OperationalModel m = random_model(6, false);
  for (const CoordinateStatistics& s : workspace(m, {}, samples(m, 1000)).coordinates) {
    EXPECT_NEAR(s.share.sum(), 1, 1e-12);
    EXPECT_NEAR(s.share_worst_case.sum(), 1, 1e-12);
    EXPECT_GE(s.share.minCoeff(), 0);
  }
  for (ChainJoint& joint : m.chain.joints) joint.prismatic = true;
  const Workspace slides = workspace(m, {}, samples(m, 100));
  EXPECT_EQ(slides.coordinates[3].share, Eigen::VectorXd::Zero(slides.coordinates[3].share.size()));
  EXPECT_EQ(slides.coordinates[3].worst_case.max, 0);
}

TEST(Workspace, IsTheStatisticOfTheErrorsAtItsConfigurations) {
  const OperationalModel m = random_model(7, false);
  const Configurations c = samples(m, 1500);
  std::uint64_t next = 0;
  std::vector<double> worst, rigorous;
  double covariance = 0;
  WorkspaceOptions options{3, {}, {}};
  options.visit = [&](std::uint64_t first, const Eigen::MatrixXd& q,
                      const std::vector<OperationalError>& errors) {
    EXPECT_EQ(first, next) << "blocks come in order";
    next += errors.size();
    EXPECT_EQ(q, draw(c, first, errors.size()));
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const OperationalError e = operational_error(m, q.col(static_cast<Eigen::Index>(i)));
      EXPECT_EQ(errors[i].worst_case, e.worst_case);
      worst.push_back(e.worst_case[1]);
      rigorous.push_back(e.rigorous[1]);
      covariance += e.weighted.row(0).dot(e.weighted.row(2)) / 12;
    }
  };
  const Workspace w = workspace(m, velocity(), c, options);
  EXPECT_EQ(next, 1500u);
  EXPECT_EQ(w.count, 1500u);
  EXPECT_EQ(w.coordinates[1].worst_case.max, *std::max_element(worst.begin(), worst.end()));
  EXPECT_DOUBLE_EQ(w.coordinates[1].worst_case.p95, exact_percentile(worst, 0.95));
  EXPECT_DOUBLE_EQ(w.coordinates[1].worst_case_rigorous.p50, exact_percentile(rigorous, 0.5));
  EXPECT_NEAR(w.mean_covariance(0, 2), covariance / 1500, 1e-12 * w.mean_covariance(0, 0));
  EXPECT_EQ(operational_error(m, w.coordinates[1].worst_case.at_max).worst_case[1],
            w.coordinates[1].worst_case.max);
}

TEST(Workspace, DerivativesAreTheFiltersNormsTimesTheCoordinatesErrors) {
  const OperationalModel m = random_model(8, true);
  const std::vector<Norms> filters = velocity();
  const Workspace w = workspace(m, filters, samples(m, 300));
  for (std::size_t i = 0; i < w.coordinates.size(); ++i) {
    EXPECT_DOUBLE_EQ(w.derivatives[0][i].worst_case.max,
                     filters[0].l1.upper * w.coordinates[i].worst_case.max);
    EXPECT_DOUBLE_EQ(w.derivatives[0][i].sigma.p99, filters[0].h2 * w.coordinates[i].sigma.p99);
  }
}

}  // namespace
}  // namespace qerr
