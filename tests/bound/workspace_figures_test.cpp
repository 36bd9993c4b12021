#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bound/batched_error.hpp"
#include "qerr/bound/workspace.hpp"
#include "support/measured_figures.hpp"

namespace qerr {
namespace {

using testing::Dice;

Configurations configurations_of_figures(Dice& dice, const OperationalModel& m, std::uint64_t count) {
  const SamplingMethod methods[]{SamplingMethod::sobol, SamplingMethod::random, SamplingMethod::list,
                                 SamplingMethod::grid};
  Configurations c{.count = count, .seed = 1 + dice.below(100), .ranges = {}};
  const std::size_t joints = m.chain.independent.size();
  for (std::size_t j = 0; j < joints; ++j) {
    const double lower = dice.between(-3, 0);
    c.ranges.push_back({lower, lower + dice.between(0.5, 3)});
  }
  c.method = methods[dice.below(4)];
  if (c.method == SamplingMethod::grid)
    c.count = static_cast<std::uint64_t>(
        std::ceil(std::pow(static_cast<double>(count), 1 / static_cast<double>(joints)) - 1e-9));
  for (std::uint64_t i = 0; c.method == SamplingMethod::list && i < count; ++i) {
    Eigen::VectorXd q = dice.vector(static_cast<Eigen::Index>(joints), 0, 1);
    for (std::size_t j = 0; j < joints; ++j) {
      double& x = q[static_cast<Eigen::Index>(j)];
      x = c.ranges[j].lower + (c.ranges[j].upper - c.ranges[j].lower) * x;
    }
    c.points.push_back(q);
  }
  return c;
}

void expect_coordinates(const testing::MeasuredFigures& expect, const OperationalModel& m,
                        const Workspace& w) {
  const std::vector<Signal> coordinates = all_signals(m);
  ASSERT_EQ(w.coordinates.size(), coordinates.size());
  for (std::size_t c = 0; c < coordinates.size(); ++c) {
    const std::string& name = coordinates[c].name;
    const CoordinateStatistics& s = w.coordinates[c];
    expect(name + " worst case", s.worst_case);
    expect(name + " rigorous", s.worst_case_rigorous);
    expect(name + " sigma", s.sigma);
    expect(name + " share", s.share);
    expect(name + " share of worst case", s.share_worst_case);
    for (std::size_t f = 0; f < w.derivatives.size(); ++f) {
      const std::string behind = name + " filter " + std::to_string(f);
      const DerivativeStatistics& d = w.derivatives[f][c];
      expect(behind + " worst case", d.worst_case);
      if (d.sigma) expect(behind + " sigma", *d.sigma);
      if (d.sigma_in_motion) expect(behind + " sigma in motion", *d.sigma_in_motion);
    }
  }
}

void expect_details(const testing::MeasuredFigures& expect, const Workspace& w) {
  expect("count", static_cast<double>(w.count));
  expect("variance part", w.mean_variance_parts.cwiseSqrt());
  expect("quantization part", w.mean_quantization_parts.cwiseSqrt());
  expect.covariance("covariance", w.mean_covariance);
  expect.covariance("largest covariance", w.covariance_at_largest);
  expect("largest at", w.largest_at);
  expect("largest arm", w.largest_arms);
  expect("cosine of pitch", w.smallest_cosine_of_pitch);
  for (std::size_t f = 0; f < w.filtered.size(); ++f) {
    const std::string behind = "filter " + std::to_string(f);
    expect.covariance(behind + " covariance", w.filtered[f].mean_covariance);
    expect.covariance(behind + " largest covariance", w.filtered[f].covariance_at_largest);
  }
}

TEST(WorkspaceFigures, OfRandomModelsAreAsMeasured) {
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    Dice dice(2100 + seed);
    OperationalModel m = testing::model_of_figures(dice, seed);
    const auto encoders = static_cast<Eigen::Index>(m.transmission.encoders.size());
    WorkspaceOptions options{.threads = 1};
    if (seed % 3 > 0) options.noise_in_motion = {dice.vector(encoders, 100, 500)};
    if (seed % 3 > 1) options.noise_in_motion.push_back(dice.vector(encoders, 0.1, 0.4));
    if (seed % 4 == 3)  // a spectrum that is not known
      for (IndependentError& s : m.sources) s.sigma_ratios = {2e3, std::nan("")};
    const Configurations c = configurations_of_figures(dice, m, 60 + dice.below(400));
    const testing::MeasuredFigures expect("model " + std::to_string(seed));
    for (const InstructionSet set : available_instruction_sets()) {
      options.instructions = set;
      const Workspace w = workspace(m, testing::two_filters(), c, options);
      EXPECT_TRUE(w.exact_percentiles);
      expect_coordinates(expect, m, w);
      expect_details(expect, w);
    }
  }
}

/// So many that percentiles are read off histograms.
TEST(WorkspaceFigures, OfManyConfigurationsAreAsMeasured) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Dice dice(2200 + seed);
    OperationalModel m = testing::model_of_figures(dice, 2 * seed);
    m.coordinates.resize(std::min<std::size_t>(m.coordinates.size(), 3));
    m.sources.resize(std::min<std::size_t>(m.sources.size(), 2));
    m.along_motion.reset();
    const Configurations c =
        configurations_of_figures(dice, m, exact_percentiles_limit + 5000 + dice.below(3000));
    if (size(c) > 3 * exact_percentiles_limit) continue;
    const testing::MeasuredFigures expect("many " + std::to_string(seed));
    for (const InstructionSet set : available_instruction_sets()) {
      WorkspaceOptions options{.threads = 1, .brief = seed % 2 == 1, .instructions = set};
      if (seed % 3 == 2) options.visit = [](const ConfigurationBatch&) {};
      const Workspace w = workspace(m, {}, c, options);
      EXPECT_FALSE(w.exact_percentiles);
      for (std::size_t k = 0; k < m.coordinates.size(); ++k) {
        const std::string name(info(m.coordinates[k]).name);
        expect(name + " worst case", w.coordinates[k].worst_case);
        expect(name + " sigma", w.coordinates[k].sigma);
      }
      expect.covariance("covariance", w.mean_covariance);
    }
  }
}

TEST(WorkspaceFigures, InBriefAreTheSameWithoutDetails) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Dice dice(2300 + seed);
    const OperationalModel m = testing::model_of_figures(dice, seed);
    const Configurations c = configurations_of_figures(dice, m, 1000);
    const Workspace whole = workspace(m, testing::two_filters(), c, {.threads = 1});
    const Workspace brief = workspace(m, testing::two_filters(), c, {.threads = 1, .brief = true});
    EXPECT_EQ(brief.count, whole.count);
    for (std::size_t k = 0; k < whole.coordinates.size(); ++k) {
      const CoordinateStatistics &a = brief.coordinates[k], &b = whole.coordinates[k];
      for (const StatisticKind& kind : statistic_kinds()) {
        EXPECT_NEAR(a.worst_case.*kind.value, b.worst_case.*kind.value, 1e-13 * b.worst_case.max);
        EXPECT_NEAR(a.sigma.*kind.value, b.sigma.*kind.value, 1e-13 * b.worst_case.max);
        EXPECT_EQ(a.worst_case_rigorous.*kind.value, 0);
      }
      EXPECT_EQ(a.share.size(), 0);
      EXPECT_EQ(a.share_worst_case.size(), 0);
    }
    EXPECT_EQ(brief.largest_arms.size(), 0);
    EXPECT_EQ(brief.largest_at.size(), 0);
    EXPECT_TRUE(brief.filtered.empty());
  }
}

TEST(WorkspaceFigures, ProgressReachesTheNumberOfConfigurations) {
  Dice dice(2400);
  const OperationalModel m = testing::model_of_figures(dice, 0);
  Configurations c{.count = 3 * 4096 * 16 + 7, .ranges = {}};
  c.ranges.assign(m.chain.independent.size(), {-1, 1});
  std::vector<std::uint64_t> done;
  WorkspaceOptions options{.threads = 1, .brief = true};
  options.progress = [&](std::uint64_t some, std::uint64_t total) {
    EXPECT_EQ(total, c.count);
    done.push_back(some);
  };
  workspace(m, {}, c, options);
  ASSERT_FALSE(done.empty());
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.front(), 16u * 4096);
  EXPECT_EQ(done.back(), c.count);
}

/// One joint about z, a metre from the tip, that turns by a multiple of its coordinate.
OperationalModel geared_joint(double multiplier) {
  OperationalModel m;
  ChainJoint joint;
  joint.name = "wheel";
  joint.axis = Eigen::Vector3d::UnitZ();
  joint.multiplier = multiplier;
  m.chain.joints = {joint};
  m.chain.independent = {{"drive", JointType::revolute, {}}};
  m.chain.tip_offset.translation() = Eigen::Vector3d::UnitX();
  m.transmission = {{{1e-5}}, Eigen::MatrixXd::Identity(1, 1)};
  m.coordinates = {Coordinate::y};
  return m;
}

TEST(WorkspaceFigures, AnglesUpToTheLargestOneAreTaken) {
  Configurations c{.method = SamplingMethod::list, .count = 2, .ranges = {{-0.3, 0.3}}};
  for (const double q : {-0.3, 0.1}) c.points.push_back(Eigen::VectorXd::Constant(1, q));
  const double largest = std::exp2(20);
  EXPECT_EQ(workspace(geared_joint(largest / 0.3), {}, c).count, 2u);
  const Fault fault = refusal([&] { workspace(geared_joint(-1.001 * largest / 0.3), {}, c); });
  EXPECT_EQ(fault.key, "configurations");
  OperationalModel offset = geared_joint(1);
  offset.chain.joints[0].offset = -largest;
  EXPECT_EQ(refusal([&] { workspace(offset, {}, c); }).key, "configurations");
  c.method = SamplingMethod::grid;
  EXPECT_EQ(workspace(geared_joint(largest / 0.3), {}, c).count, 2u);
  c.ranges = {{-0.4, 0.3}};
  EXPECT_EQ(refusal([&] { workspace(geared_joint(largest / 0.3), {}, c); }).key, "configurations");
}

}  // namespace
}  // namespace qerr
