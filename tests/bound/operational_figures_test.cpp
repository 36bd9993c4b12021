#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "bound/error_columns.hpp"
#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/workspace.hpp"
#include "support/effect_experiment.hpp"
#include "support/measured_figures.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// Everything that the scalar functions give at one configuration.
TEST(OperationalErrorFigures, OfRandomModelsAreAsMeasured) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Dice dice(2500 + seed);
    const OperationalModel m = testing::model_of_figures(dice, seed);
    const Eigen::VectorXd q = testing::random_configuration(dice, m.chain);
    const OperationalError e = operational_error(m, q);
    const testing::MeasuredFigures expect("scalar " + std::to_string(seed));
    expect("mean", e.mean);
    expect("half width", e.half_width);
    expect("worst case", e.worst_case);
    expect("rigorous", e.rigorous);
    expect("sigma", e.sigma);
    expect("weighted", e.weighted);
    expect("cosine of pitch", e.cosine_of_pitch);
    expect("added sigma", e.added_sigma);
    expect("added worst case", e.added_worst);
    const std::vector<Norms> filters = testing::two_filters();
    const Eigen::VectorXd ratios = dice.vector(e.added_sigma.cols(), 0.5, 3);
    expect.covariance("covariance", covariance(e));
    expect.covariance("filtered covariance", covariance(e, filters[0].h2, ratios));
    for (Eigen::Index c = 0; c < e.sigma.size(); ++c) {
      const Bounds b = derivative_error(e, c, filters[1], ratios);
      const std::string name = "derivative " + std::to_string(c);
      expect(name + " worst case", b.worst_case);
      expect(name + " sigma", b.sigma);
    }
    const JointError joints = joint_error(m);
    expect("joint mean", joints.mean);
    expect("joint half width", joints.half_width);
    expect("joint worst case", joints.worst_case);
    expect("joint sigma", joints.sigma);
  }
}

/// Two joints, about z and y, a metre from the tip: yaw and pitch.
OperationalModel yaw_and_pitch() {
  OperationalModel m;
  for (const std::size_t k : {0u, 1u}) {
    ChainJoint joint;
    joint.name = k == 0 ? "yaw" : "pitch";
    joint.axis = k == 0 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    joint.coordinate = k;
    m.chain.joints.push_back(joint);
    m.chain.independent.push_back({joint.name, JointType::revolute, {}});
  }
  m.chain.tip_offset.translation() = Eigen::Vector3d::UnitX();
  m.transmission = {{{1e-3, Rounding::down, true}, {2e-3}}, Eigen::Matrix2d::Identity()};
  m.sources.push_back({.owner = 1, .mean = 1e-4, .half_width = 2e-4, .sigma = 1e-4});
  return m;
}

TEST(OperationalErrorFigures, AtTheGimbalLockAreInfiniteForEulerAnglesOnly) {
  const Eigen::Vector2d lock(0, std::acos(0.0));
  OperationalModel m = yaw_and_pitch();
  m.coordinates = {Coordinate::yaw, Coordinate::x, Coordinate::pitch, Coordinate::z, Coordinate::roll};
  const OperationalError e = operational_error(m, lock);
  EXPECT_LT(e.cosine_of_pitch, 1e-15);
  for (const Eigen::Index unbounded : {0, 2, 4}) {
    for (const Eigen::VectorXd* figure : {&e.half_width, &e.worst_case, &e.rigorous, &e.sigma})
      EXPECT_EQ((*figure)[unbounded], INFINITY);
    EXPECT_EQ(e.mean[unbounded], 0);
    EXPECT_EQ(e.weighted.row(unbounded), Eigen::RowVector2d(INFINITY, INFINITY));
    EXPECT_EQ(e.added_sigma(unbounded, 0), 0);
    EXPECT_EQ(e.added_worst(unbounded, 0), 0);
    const Bounds b = derivative_error(e, unbounded, testing::two_filters()[0], Eigen::VectorXd::Ones(1));
    EXPECT_EQ(b.worst_case, INFINITY);
    EXPECT_EQ(b.sigma, INFINITY);
  }
  m.coordinates = {Coordinate::x, Coordinate::z};
  const OperationalError positions = operational_error(m, lock);
  for (const Eigen::Index k : {0, 1}) {
    EXPECT_EQ(e.worst_case[2 * k + 1], positions.worst_case[k]);
    EXPECT_EQ(e.sigma[2 * k + 1], positions.sigma[k]);
    EXPECT_EQ(e.rigorous[2 * k + 1], positions.rigorous[k]);
  }
}

RobotUsage usage_of_everything(Dice& dice, OperationalModel& m) {
  std::vector<Limits> ranges;
  for (IndependentJoint& joint : m.chain.independent) {
    const double lower = dice.between(-2, 0.5);
    ranges.push_back({lower, lower + dice.between(0.5, 2)});
    if (dice.chance(0.8)) joint.velocity_limit = dice.between(0.5, 3);
    if (dice.chance(0.8)) joint.effort_limit = dice.between(5, 50);
  }
  RobotUsage usage = usage_from_limits(m, ranges);
  for (auto* of : {&usage.joints, &usage.encoders})
    for (Usage& u : *of) {
      u.duration = dice.between(1, 60);
      u.temperature = Spread{0, 20, 12, 170};
    }
  return usage;
}

/// Of every stage; a list, so that new kinds leave the figures unchanged.
constexpr const char* drawn_effects[]{
    "offset",      "scale",         "eccentricity", "transmission_error", "backlash",
    "compliance",  "drift",         "geometry",     "subdivision_error",  "decoding",
    "state_width", "missed_counts", "truncation",   "rollover",           "latency",
    "clock_drift", "timing_jitter", "noise",        "reference_error"};

/// Effects that widen the range of those behind them, at joints and encoders of coupled transmissions.
TEST(EffectShareFigures, OfRandomEffectsAreAsMeasured) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Dice dice(2700 + seed);
    OperationalModel m = testing::random_model(dice, 0, 0);
    for (Encoder& e : m.transmission.encoders) {
      e.shaft_ratio = 10;
      e.counts_per_period = 64;
    }
    const RobotUsage usage = usage_of_everything(dice, m);
    std::vector<Effect> effects;
    for (int i = 0; i < 16; ++i) {
      const EffectKind& kind = effect_kind(drawn_effects[dice.below(std::size(drawn_effects))]);
      const std::size_t joint = dice.below(m.chain.independent.size());
      effects.push_back(testing::random_effect(dice, kind, m.chain.independent[joint].name,
                                               m.transmission.encoders[joint]));
      for (auto& [name, value] : effects.back().numbers)
        if (name == "compliance" || name == "coefficient") value = 1e-5;
    }
    const testing::MeasuredFigures expect("effects " + std::to_string(seed));
    for (std::size_t j = 0; j < usage.encoders.size(); ++j) {
      const Spread& s = *usage.encoders[j].position;
      expect("encoder " + std::to_string(j), Eigen::Vector4d(s.lower, s.upper, s.mean, s.mean_square));
    }
    const std::vector<EffectShare> shares = effect_shares(m, effects, usage);
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const std::string name = std::to_string(i) + ' ' + shares[i].effect.type;
      expect(name + " included", shares[i].included);
      if (shares[i].share)
        expect(name,
               Eigen::Vector3d(shares[i].share->mean, shares[i].share->half_width, shares[i].share->sigma));
    }
    const std::vector<IndependentError> sources = error_sources(m, shares, testing::two_filters());
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const IndependentError& s = sources[i];
      const std::string name = "source " + std::to_string(i);
      expect(name + " place", static_cast<double>(100 * static_cast<int>(s.where) + 10 * s.owner + s.link));
      expect(name, Eigen::Vector3d(s.mean, s.half_width, s.sigma));
      ASSERT_EQ(s.sigma_ratios.size(), 2u);
      for (const double ratio : s.sigma_ratios)
        if (std::isfinite(ratio)) expect(name + (ratio == s.sigma_ratios[0] ? " first" : " second"), ratio);
    }
  }
}

/// Models whose figures a sweep computes from shared columns, with all that `workspace` gives, too.
TEST(ColumnWorkspaceFigures, InMotionAreThoseOfTheWorkspace) {
  const std::vector<Norms> filters = testing::two_filters();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Dice dice(2600 + seed);
    OperationalModel m = testing::model_of_figures(dice, 5 * seed + (seed % 2 == 0 ? 2 : 1));
    m.coordinates.assign(testing::all_coordinates, testing::all_coordinates + 6);
    m.lengths.clear();
    for (Encoder& e : m.transmission.encoders) e.rounding = Rounding::nearest;
    for (IndependentError& s : m.sources) s.mean = 0;
    if (m.along_motion) {
      m.along_motion->tip = testing::moments_of_motion(dice, 6, 3e-4);
      m.along_motion->filtered = {testing::moments_of_motion(dice, 6, 0.1),
                                  testing::moments_of_motion(dice, 6, 1e-4)};
    }
    Configurations c{.count = 4096 + dice.below(500), .seed = 3, .ranges = {}};
    c.ranges.assign(m.chain.independent.size(), {-2, 2});
    ASSERT_TRUE(have_columns(m));
    const auto encoders = static_cast<Eigen::Index>(m.transmission.encoders.size());
    const std::vector<Eigen::VectorXd> noise{dice.vector(encoders, 100, 500),
                                             dice.vector(encoders, 0.1, 0.4)};
    std::vector<const StatisticKind*> kinds;
    for (const StatisticKind& kind : statistic_kinds()) kinds.push_back(&kind);
    const ErrorColumns columns(m, m.sources, c, 1);
    const ColumnStatistics statistics(columns, WantedStatistics::of(kinds), 1);
    const ColumnModel model{&m, &filters, error_weights(columns, m, filters, noise)};
    const Workspace found = workspaces(statistics, {&model, 1}).front();
    const Workspace wanted = workspace(m, filters, c, {.threads = 1, .noise_in_motion = noise});
    for (std::size_t k = 0; k < 6; ++k) {
      const auto expect_near = [&](const Statistic& a, const Statistic& b, double scale) {
        for (const StatisticKind* kind : kinds)
          EXPECT_NEAR(a.*kind->value, b.*kind->value, 1e-11 * b.max + 1e-14 * scale) << seed << kind->name;
      };
      expect_near(found.coordinates[k].worst_case, wanted.coordinates[k].worst_case, 1e-2);
      expect_near(found.coordinates[k].worst_case_rigorous, wanted.coordinates[k].worst_case_rigorous, 1e-2);
      expect_near(found.coordinates[k].sigma, wanted.coordinates[k].sigma, 1e-2);
      for (std::size_t f = 0; f < filters.size(); ++f) {
        const DerivativeStatistics &a = found.derivatives[f][k], &b = wanted.derivatives[f][k];
        expect_near(a.worst_case, b.worst_case, 10);
        ASSERT_EQ(a.sigma.has_value(), b.sigma.has_value());
        if (a.sigma) expect_near(*a.sigma, *b.sigma, 10);
        ASSERT_EQ(a.sigma_in_motion.has_value(), b.sigma_in_motion.has_value());
        if (a.sigma_in_motion) expect_near(*a.sigma_in_motion, *b.sigma_in_motion, 10);
      }
    }
  }
}

}  // namespace
}  // namespace qerr
