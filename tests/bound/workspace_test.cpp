#include "qerr/bound/workspace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bound/batched_error.hpp"
#include "core/random.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/batch.hpp"
#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// numpy.percentile(values, 100 p), method linear.
double exact_percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double position = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  if (below + 1 >= values.size()) return values.back();
  return values[below] + (position - static_cast<double>(below)) * (values[below + 1] - values[below]);
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
    expect_scaled(*a.derivatives[0][i].sigma, *b.derivatives[0][i].sigma, factor);
  }
  EXPECT_EQ(a.mean_variance_parts, factor * factor * b.mean_variance_parts);
  EXPECT_EQ(a.mean_covariance, factor * factor * b.mean_covariance);
  EXPECT_EQ(a.covariance_at_largest, factor * factor * b.covariance_at_largest);
  EXPECT_EQ(a.largest_at, b.largest_at);
  EXPECT_EQ(a.largest_arms, b.largest_arms);
  EXPECT_EQ(a.smallest_cosine_of_pitch, b.smallest_cosine_of_pitch);
}

TEST(Workspace, IsBitwiseEqualForEveryNumberOfThreads) {
  for (const bool nearest_only : {true, false})
    for (const std::uint64_t count : {std::uint64_t{3333}, exact_percentiles_limit + 9999}) {
      const OperationalModel m = random_model(4, nearest_only);
      const Configurations c = samples(m, count);
      const Workspace one = workspace(m, velocity(), c, {1});
      for (const unsigned threads : {2u, 3u, 7u})
        expect_scaled(workspace(m, velocity(), c, {threads}), one, 1, true);
    }
}

// Halving is exact in binary, and so is every figure that is linear in Delta.
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

// 1e-12 of the scalar reference; complete and partial batches.
TEST(Workspace, IsTheStatisticOfTheErrorsAtItsConfigurations) {
  const OperationalModel m = random_model(7, false);
  for (const std::uint64_t count : {1u, 63u, 64u, 1500u, 4097u}) {
    const Configurations c = samples(m, count);
    std::vector<double> worst, rigorous;
    double covariance = 0;
    Eigen::MatrixXd parts =
        Eigen::MatrixXd::Zero(5, static_cast<Eigen::Index>(m.transmission.encoders.size()));
    for (std::uint64_t i = 0; i < count; ++i) {
      const OperationalError e = operational_error(m, draw(c, i, 1).col(0));
      worst.push_back(e.worst_case[1]);
      rigorous.push_back(e.rigorous[1]);
      covariance += e.weighted.row(0).dot(e.weighted.row(2)) / 12;
      parts += e.weighted.cwiseAbs2() / 12;
    }
    const auto n = static_cast<double>(count);
    for (const InstructionSet set : available_instruction_sets()) {
      WorkspaceOptions options{3};
      options.instructions = set;
      const Workspace w = workspace(m, velocity(), c, options);
      EXPECT_EQ(w.count, count);
      const double largest = *std::max_element(worst.begin(), worst.end());
      EXPECT_NEAR(w.coordinates[1].worst_case.max, largest, 1e-12 * largest);
      EXPECT_NEAR(w.coordinates[1].worst_case.p95, exact_percentile(worst, 0.95), 1e-12 * largest);
      EXPECT_NEAR(w.coordinates[1].worst_case_rigorous.p50, exact_percentile(rigorous, 0.5), 1e-12 * largest);
      EXPECT_NEAR(w.mean_covariance(0, 2), covariance / n, 1e-12 * w.mean_covariance(0, 0));
      EXPECT_LT((w.mean_variance_parts - parts / n).cwiseAbs().maxCoeff(), 1e-12 * parts.maxCoeff() / n);
      EXPECT_NEAR(operational_error(m, w.coordinates[1].worst_case.at_max).worst_case[1], largest,
                  1e-12 * largest);
    }
  }
}

TEST(Workspace, TextsAreInOrderForEveryNumberOfThreads) {
  const OperationalModel m = random_model(7, false);
  const Configurations c = samples(m, 70000);
  std::string expected;
  for (const unsigned threads : {1u, 4u}) {
    WorkspaceOptions options{threads};
    std::uint64_t next = 0;
    std::string all;
    options.text = [&](const ConfigurationBatch& batch) {
      EXPECT_EQ(batch.q[1], draw(c, batch.first + 1, 1)(0, 0));
      return std::to_string(batch.first) + '+' + std::to_string(batch.count) + ' ' +
             std::to_string(batch.figures[batch.layout.sigma * batch_size]) + '\n';
    };
    options.write = [&](const std::string& text) { all += text; };
    workspace(m, {}, c, options);
    for (std::size_t i = 0; i < all.size(); i = all.find('\n', i) + 1, next += batch_size)
      ASSERT_TRUE(all.substr(i).starts_with(std::to_string(next) + '+'));
    EXPECT_EQ(next, (70000 + batch_size - 1) / batch_size * batch_size);
    if (threads == 1) expected = all;
    EXPECT_EQ(all, expected);
  }
}

/// One figure at every configuration. Above the limit percentiles are from bins: tolerance 1e-3.
std::vector<double> values_of(const OperationalModel& m, const Configurations& c, std::size_t figure) {
  BatchedError batched(m, {});
  Sampler sampler(c);
  AlignedNumbers q(m.chain.independent.size() * batch_size), figures(batched.figures().count * batch_size);
  std::vector<double> values;
  for (std::uint64_t first = 0; first < size(c); first += batch_size) {
    sampler(first, q.data());
    batched(q.data(), figures.data());
    const double* const of_batch = &figures[figure * batch_size];
    values.insert(values.end(), of_batch, of_batch + std::min<std::uint64_t>(batch_size, size(c) - first));
  }
  return values;
}

void expect_statistic_of(const std::vector<double>& values, const Statistic& s) {
  EXPECT_EQ(s.max, *std::max_element(values.begin(), values.end()));
  EXPECT_EQ(s.min, *std::min_element(values.begin(), values.end()));
  for (const auto& [value, p] : {std::pair{s.p50, 0.5}, {s.p95, 0.95}, {s.p99, 0.99}})
    EXPECT_NEAR(value, exact_percentile(values, p), 1e-3 * value);
}

TEST(Workspace, BinnedPercentilesAreThoseOfTheConfigurations) {
  const OperationalModel m = random_model(9, true);
  for (const SamplingMethod method : {SamplingMethod::sobol, SamplingMethod::grid}) {
    Configurations c = samples(m, exact_percentiles_limit + 777);
    c.method = method;
    if (method == SamplingMethod::grid) c.count = 20;
    const Workspace w = workspace(m, {}, c);
    ASSERT_FALSE(w.exact_percentiles) << w.count;
    const FigureLayout figures = BatchedError(m, {}).figures();
    expect_statistic_of(values_of(m, c, figures.worst_case), w.coordinates[0].worst_case);
    expect_statistic_of(values_of(m, c, figures.sigma + 2), w.coordinates[2].sigma);
  }
}

TEST(Workspace, BinnedPercentilesAreThoseOfTheConfigurationsWithAllInstructions) {
  const OperationalModel m = random_model(9, true);
  const Configurations c = samples(m, exact_percentiles_limit + 777);
  const std::vector<double> values = values_of(m, c, BatchedError(m, {}).figures().sigma + 1);
  for (const InstructionSet set : available_instruction_sets()) {
    const Statistic s = workspace(m, {}, c, {.brief = true, .instructions = set}).coordinates[1].sigma;
    for (const auto& [value, p] : {std::pair{s.p50, 0.5}, {s.p95, 0.95}, {s.p99, 0.99}})
      EXPECT_NEAR(value, exact_percentile(values, p), 1e-4 * value) << name_of(set);
  }
}

/// A link of 1 m, rotating about z: dx/dq = -sin q.
OperationalModel one_link() {
  OperationalModel m = random_model(10, true);
  m.chain.joints.resize(1);
  m.chain.joints[0] = {};
  m.chain.joints[0].axis = Eigen::Vector3d::UnitZ();
  m.chain.independent.resize(1);
  m.chain.tip_offset = Eigen::Isometry3d::Identity();
  m.chain.tip_offset.translation() = Eigen::Vector3d::UnitX();
  m.transmission = {{{1e-4}}, Eigen::MatrixXd::Identity(1, 1)};
  m.coordinates = {Coordinate::x};
  return m;
}

// The points that the job samples in advance (WorkspaceJob::draw_sample) are not representative here.
TEST(Workspace, BinnedPercentilesAreAccurateForAnUnrepresentativeSample) {
  Configurations c;
  c.method = SamplingMethod::list;
  c.count = exact_percentiles_limit + 4096;
  c.ranges = {{0, 1.5}};
  Dice dice(12);
  for (std::uint64_t i = 0; i < c.count; ++i)
    c.points.push_back(Eigen::VectorXd::Constant(1, dice.between(0.1, 0.2)));
  for (std::uint64_t b = 0; b < 64; ++b)
    for (std::uint64_t i = 0; i < batch_size; ++i) {
      const std::uint64_t batch = random_bits(b, i, 0) % (c.count / batch_size);
      c.points[batch * batch_size + random_bits(b, i, 1) % batch_size][0] = dice.between(1, 1.2);
    }
  std::vector<double> errors;
  for (const Eigen::VectorXd& q : c.points) errors.push_back(5e-5 * std::sin(q[0]));
  const Statistic s = workspace(one_link(), {}, c).coordinates[0].worst_case;
  for (const auto& [value, p] : {std::pair{s.p50, 0.5}, {s.p95, 0.95}, {s.p99, 0.99}})
    EXPECT_NEAR(value, exact_percentile(errors, p), 1e-4 * value);
  const auto largest = std::max_element(errors.begin(), errors.end());
  EXPECT_DOUBLE_EQ(s.max, *largest);
  EXPECT_EQ(s.at_max, c.points[static_cast<std::size_t>(largest - errors.begin())]);
}

// Every row of the grid ends at a pitch of 90 deg; all other points have finite bounds.
TEST(Workspace, MaximumOfAnUnboundedCoordinateIsAtItsSingularity) {
  OperationalModel m = one_link();
  m.chain.joints.push_back(m.chain.joints[0]);
  m.chain.joints[1].axis = Eigen::Vector3d::UnitY();
  m.chain.joints[1].coordinate = 1;
  m.chain.independent.push_back(m.chain.independent[0]);
  m.transmission = {{{1e-4}, {1e-4}}, Eigen::Matrix2d::Identity()};
  m.coordinates = {Coordinate::x, Coordinate::yaw};
  Configurations c;
  c.method = SamplingMethod::grid;
  c.ranges = {{0, 1}, {0, std::numbers::pi / 2}};
  for (const std::uint64_t count : {std::uint64_t{300}, std::uint64_t{400}}) {
    c.count = count;
    const Workspace w = workspace(m, {}, c);
    EXPECT_EQ(w.exact_percentiles, count == 300);
    EXPECT_EQ(w.coordinates[1].sigma.max, INFINITY);
    EXPECT_EQ(w.coordinates[1].sigma.mean, INFINITY);
    EXPECT_EQ(w.coordinates[1].sigma.at_max, Eigen::Vector2d(0, std::numbers::pi / 2));
    EXPECT_EQ(w.mean_covariance(1, 1), INFINITY);
    EXPECT_EQ(w.mean_covariance(1, 0), INFINITY);
    EXPECT_TRUE(std::isfinite(w.mean_covariance(0, 0)));
  }
}

// The first point of a grid has a coordinate without error.
TEST(Workspace, BinnedPercentilesAreIndependentOfTheFirstConfigurations) {
  const OperationalModel m = one_link();
  Configurations c;
  c.method = SamplingMethod::grid;
  c.count = 200000;
  c.ranges = {{0, 1.5}};
  // x moves by sin q: its median over the grid is sin 0.75.
  EXPECT_NEAR(workspace(m, {}, c).coordinates[0].worst_case.p50, 5e-5 * std::sin(0.75), 5e-8);
  c.ranges = {{0, 1e7}};
  EXPECT_THROW(workspace(m, {}, c), Error);
}

TEST(Workspace, DerivativesAreTheFiltersNormsTimesTheCoordinatesErrors) {
  const OperationalModel m = random_model(8, true);
  const std::vector<Norms> filters = velocity();
  const Workspace w = workspace(m, filters, samples(m, 300));
  for (std::size_t i = 0; i < w.coordinates.size(); ++i) {
    EXPECT_DOUBLE_EQ(w.derivatives[0][i].worst_case.max,
                     filters[0].l1.upper * w.coordinates[i].worst_case.max);
    EXPECT_DOUBLE_EQ(w.derivatives[0][i].sigma->p99, filters[0].h2 * w.coordinates[i].sigma.p99);
  }
}

}  // namespace
}  // namespace qerr
