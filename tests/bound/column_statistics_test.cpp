#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bound/error_columns.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::Dice;

std::vector<const StatisticKind*> all_kinds() {
  std::vector<const StatisticKind*> kinds;
  for (const StatisticKind& kind : statistic_kinds()) kinds.push_back(&kind);
  return kinds;
}

/// Largest difference of two statistics, relative to the tolerance: 1e-12 of their maximum, and of the
/// largest figure of this kind 1e-14, which is the rounding of a coordinate that does not move.
double gap(const Statistic& a, const Statistic& b, const std::vector<const StatisticKind*>& kinds,
           double largest) {
  double difference = 0;
  for (const StatisticKind* kind : kinds)
    difference = std::max(difference, std::abs(a.*kind->value - b.*kind->value));
  return difference == 0 ? 0 : difference / (1e-12 * b.max + 1e-14 * largest);
}

/// A model that has no coordinates but those with columns.
OperationalModel model_with_columns(Dice& dice, std::size_t filters) {
  OperationalModel m = testing::random_model(dice, filters, dice.chance(0.5) ? 1 : 0);
  m.coordinates.assign(testing::all_coordinates, testing::all_coordinates + (dice.chance(0.5) ? 3 : 6));
  return m;
}

Configurations random_configurations(Dice& dice, std::size_t joints) {
  Configurations c{.count = 4096 + dice.below(3000), .seed = 1 + dice.below(100), .ranges = {}};
  c.ranges.assign(joints, {-3, 3});
  if (dice.chance(0.3)) c.method = SamplingMethod::random;
  if (dice.chance(0.5)) {  // many equal values
    c.method = SamplingMethod::list;
    const std::size_t distinct = 2 + dice.below(300);
    std::vector<Eigen::VectorXd> points;
    for (std::size_t i = 0; i < distinct; ++i)
      points.push_back(dice.vector(static_cast<Eigen::Index>(joints), -3, 3));
    // Or values that float cannot order.
    const double spread = dice.chance(0.5) ? 1e-8 : 0;
    for (std::size_t i = 0; i < c.count; ++i)
      c.points.push_back(points[i % distinct] +
                         dice.vector(static_cast<Eigen::Index>(joints), -spread, spread));
  }
  return c;
}

/// The model with other encoders, from fine to so coarse that the remainder is a large part of the bound.
OperationalModel variant(OperationalModel m, Dice& dice) {
  for (Encoder& e : m.transmission.encoders) e.resolution = std::pow(10, dice.between(-7, -1.5));
  if (dice.chance(0.1))
    for (Encoder& e : m.transmission.encoders) e.resolution = 1e-9;
  return m;
}

void expect_equal(const Workspace& found, const Workspace& wanted,
                  const std::vector<const StatisticKind*>& kinds, std::uint64_t seed) {
  ASSERT_EQ(found.coordinates.size(), wanted.coordinates.size());
  const auto expect_near = [&](const Statistic& a, const Statistic& b, const auto& largest_of) {
    double largest = 0;  // of the positions, or of the rotations
    for (std::size_t c = 0; c < wanted.coordinates.size(); ++c) largest = std::max(largest, largest_of(c));
    EXPECT_LE(gap(a, b, kinds, largest), 1) << seed;
  };
  for (std::size_t c = 0; c < wanted.coordinates.size(); ++c) {
    const CoordinateStatistics &a = found.coordinates[c], &b = wanted.coordinates[c];
    const auto worst = [&](std::size_t other) {
      return other / 3 == c / 3 ? wanted.coordinates[other].worst_case.max : 0;
    };
    expect_near(a.worst_case, b.worst_case, worst);
    expect_near(a.sigma, b.sigma, worst);
    expect_near(a.worst_case_rigorous, b.worst_case_rigorous, worst);
    for (std::size_t f = 0; f < wanted.derivatives.size(); ++f) {
      const DerivativeStatistics &d = found.derivatives[f][c], &e = wanted.derivatives[f][c];
      const auto filtered = [&](std::size_t other) {
        return other / 3 == c / 3 ? wanted.derivatives[f][other].worst_case.max : 0;
      };
      expect_near(d.worst_case, e.worst_case, filtered);
      ASSERT_EQ(d.sigma.has_value(), e.sigma.has_value()) << seed;
      if (d.sigma) expect_near(*d.sigma, *e.sigma, filtered);
    }
  }
  const double largest = wanted.mean_variance_parts.cwiseAbs().maxCoeff();
  EXPECT_LE((found.mean_variance_parts - wanted.mean_variance_parts).cwiseAbs().maxCoeff(), 1e-12 * largest);
}

TEST(ColumnStatistics, EqualsTheWorkspaceOfEveryModel) {
  const std::vector<InstructionSet> sets = available_instruction_sets();
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Dice dice(seed);
    const std::size_t filters = dice.below(3);
    const OperationalModel base = model_with_columns(dice, filters);
    const Configurations configurations = random_configurations(dice, base.transmission.encoders.size());
    ASSERT_TRUE(have_columns(base));
    std::vector<Norms> all;
    for (std::size_t f = 0; f < filters; ++f)
      all.push_back(norms(difference_filter(1000, 1 + static_cast<int>(f))));
    std::vector<const StatisticKind*> kinds = all_kinds();
    if (dice.chance(0.5)) kinds = {find_statistic("max"), find_statistic("p99")};
    const InstructionSet set = sets[seed % sets.size()];
    const ErrorColumns columns(base, base.sources, configurations, 1, set);
    const ColumnStatistics statistics(columns, WantedStatistics::of(kinds), 1, set);
    std::vector<OperationalModel> variants;
    for (std::size_t i = 0; i < 1 + 7 * (seed % 6); ++i) variants.push_back(variant(base, dice));
    std::vector<ColumnModel> models;
    for (const OperationalModel& m : variants) models.push_back({&m, &all, error_weights(columns, m, all)});
    const std::vector<Workspace> found = workspaces(statistics, models);
    for (std::size_t i = 0; i < variants.size(); i += 5) {
      WorkspaceOptions options;
      options.threads = 1;
      options.instructions = set;
      expect_equal(found[i], workspace(variants[i], all, configurations, options), kinds, seed);
    }
  }
}

TEST(ColumnStatistics, AreExactWhereASampleOfTheBatchesMisleads) {
  // Batches of 64; every 32nd one, which is the sample, has other configurations than those between them.
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Dice dice(seed);
    const OperationalModel model = model_with_columns(dice, 0);
    const auto joints = static_cast<Eigen::Index>(model.transmission.encoders.size());
    Configurations configurations{.count = 64 * 64, .ranges = {}};
    configurations.ranges.assign(static_cast<std::size_t>(joints), {-3, 3});
    configurations.method = SamplingMethod::list;
    const Eigen::VectorXd rest = dice.vector(joints, -3, 3);
    for (std::size_t i = 0; i < configurations.count; ++i)
      configurations.points.push_back(i / 64 % 32 == 0 ? dice.vector(joints, -3, 3) : rest);
    const std::vector<const StatisticKind*> kinds{find_statistic("max"), find_statistic("p99")};
    const ErrorColumns columns(model, model.sources, configurations, 1);
    const ColumnStatistics statistics(columns, WantedStatistics::of(kinds), 1);
    const std::vector<Norms> none;
    const ColumnModel wanted{&model, &none, error_weights(columns, model, none)};
    WorkspaceOptions options;
    options.threads = 1;
    expect_equal(workspaces(statistics, {&wanted, 1}).front(),
                 workspace(model, none, configurations, options), kinds, seed);
  }
}

TEST(ColumnStatistics, DoNotDependOnWhatElseIsEvaluated) {
  Dice dice(5);
  const OperationalModel base = model_with_columns(dice, 0);
  const Configurations configurations = random_configurations(dice, base.transmission.encoders.size());
  const ErrorColumns columns(base, base.sources, configurations, 1);
  const ColumnStatistics all(columns, WantedStatistics::of(all_kinds()), 1);
  const ColumnStatistics few(columns, WantedStatistics::of({find_statistic("p95")}), 1);
  const std::vector<Norms> none;
  std::vector<OperationalModel> variants;
  for (std::size_t i = 0; i < 40; ++i) variants.push_back(variant(base, dice));
  std::vector<ColumnModel> models;
  for (const OperationalModel& m : variants) models.push_back({&m, &none, error_weights(columns, m, none)});
  const std::vector<Workspace> together = workspaces(all, models);
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Workspace alone = workspaces(few, {&models[i], 1}).front();
    for (std::size_t c = 0; c < base.coordinates.size(); ++c) {
      EXPECT_EQ(alone.coordinates[c].worst_case.p95, together[i].coordinates[c].worst_case.p95);
      EXPECT_EQ(alone.coordinates[c].worst_case_rigorous.p95,
                together[i].coordinates[c].worst_case_rigorous.p95);
      EXPECT_EQ(alone.coordinates[c].sigma.p95, together[i].coordinates[c].sigma.p95);
    }
  }
}

TEST(ColumnStatistics, AreNotForEulerAnglesAndLengths) {
  Dice dice(3);
  const OperationalModel model = model_with_columns(dice, 0);
  EXPECT_TRUE(have_columns(model));
  OperationalModel euler = model;
  euler.coordinates.push_back(Coordinate::yaw);
  EXPECT_FALSE(have_columns(euler));
  OperationalModel length = model;
  length.lengths = {Coordinate::xyz};
  EXPECT_FALSE(have_columns(length));
}

// Beyond exact_percentiles_limit the workspace counts in bins, which are right to 1e-3.
TEST(ColumnStatistics, HaveExactPercentilesOfManyConfigurations) {
  Dice dice(7);
  const OperationalModel model = model_with_columns(dice, 0);
  Configurations configurations{.count = exact_percentiles_limit + 1000, .ranges = {}};
  configurations.ranges.assign(model.transmission.encoders.size(), {-3, 3});
  const ErrorColumns columns(model, model.sources, configurations, 1);
  const ColumnStatistics statistics(columns, WantedStatistics::of(all_kinds()), 1);
  const std::vector<Norms> none;
  const ColumnModel one{&model, &none, error_weights(columns, model, none)};
  const Workspace found = workspaces(statistics, {&one, 1}).front(),
                  binned = workspace(model, none, configurations);
  ASSERT_FALSE(binned.exact_percentiles);
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Statistic &a = found.coordinates[c].worst_case, &b = binned.coordinates[c].worst_case;
    EXPECT_NEAR(a.p95, b.p95, 1e-3 * b.max);
    EXPECT_NEAR(a.p50, b.p50, 1e-3 * b.max);
    EXPECT_NEAR(a.mean, b.mean, 1e-12 * b.max);
  }
}

}  // namespace
}  // namespace qerr
