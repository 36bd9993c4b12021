#include "qerr/bound/independent_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "qerr/bound/workspace.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "support/design_filter.hpp"
#include "support/effect_experiment.hpp"

namespace qerr {
namespace {

using testing::Dice;
using testing::model_of;
using testing::random_effect;
using testing::random_motion;
using testing::rounding;
using testing::with_sources;

/// At the tip: no simulated error exceeds the rigorous bound along the path.
TEST(OperationalError, WithEffectsDominatesEverySimulatedTipError) {
  Dice dice(15);
  double used = 0;
  for (int trial = 0; trial < 25; ++trial) {
    const std::size_t joints = 2 + dice.below(4);
    const Chain chain =
        make_chain(testing::random_robot(dice, {.joints = joints, .prismatic = 0.2, .mimic = 0}), "", "");
    OperationalModel model =
        model_of(chain, testing::random_transmission(dice, chain, 1e-4, 1e-2, trial % 2 == 0));
    model.coordinates.insert(model.coordinates.end(), {Coordinate::rx, Coordinate::ry, Coordinate::rz});
    const Motion motion = random_motion(dice, joints, 2);
    std::vector<Effect> effects;
    for (const char* type : {"backlash", "eccentricity", "transmission_error", "scale", "latency", "drift"}) {
      const std::size_t joint = dice.below(joints);
      effects.push_back(random_effect(dice, effect_kind(type), chain.independent[joint].name,
                                      model.transmission.encoders[joint]));
    }
    const OperationalModel real = with_sources(model, effects, motion);
    SimulationOptions options;
    options.threads = 1;
    const Simulation s = simulate(real, {}, {}, motion, effects, options);
    constexpr double of_one = 1e-16;  // [rad or m]: sliding joints alone turn the tip by it
    for (const SimulatedSignal& signal : s.results[0]) {
      EXPECT_LE(signal.peak_simulated, signal.worst_case_path * (1 + rounding) + of_one) << trial;
      used = std::max(used, signal.peak_simulated / signal.worst_case_path);
    }
  }
  EXPECT_GT(used, 0.4);
}

/// A wrong origin in the model: the difference of two forward kinematics.
TEST(OperationalError, OfADisplacedOriginIsTheDifferenceOfTheTwoRobots) {
  Dice dice(16);
  for (int trial = 0; trial < 30; ++trial) {
    const RobotModel robot = testing::random_robot(dice, {.joints = 4, .mimic = 0, .fixed = 0.5});
    OperationalModel model = model_of(make_chain(robot, "", ""), {});
    model.transmission = testing::random_transmission(dice, model.chain, 1e-5, 1e-4, false);
    for (Encoder& e : model.transmission.encoders) e.rounding = Rounding::nearest;
    const std::size_t moved = dice.below(4);
    const double length = dice.between(-1e-3, 1e-3);
    const std::string axis = std::vector<std::string>{"x", "y", "z"}[dice.below(3)];
    Effect effect{"geometry", model.chain.independent[moved].name, {{"length", length}}, {{"axis", axis}}};
    RobotModel built = robot;
    for (Joint& joint : built.joints)
      if (joint.name == effect.joint)
        joint.origin.translation()[axis == "x" ? 0 : axis == "y" ? 1 : 2] += length;
    const Chain truth = make_chain(built, "", "");
    const RobotUsage unknown{std::vector<Usage>(4), std::vector<Usage>(4)};
    model.sources = error_sources(model, effect_shares(model, {effect}, unknown), {});
    Eigen::VectorXd q(4);
    for (Eigen::Index i = 0; i < 4; ++i) q[i] = dice.between(-2, 2);
    const OperationalError e = operational_error(model, q);
    const Eigen::Vector3d difference =
        forward_kinematics(model.chain, q).translation() - forward_kinematics(truth, q).translation();
    for (Eigen::Index c = 0; c < 3; ++c) {
      EXPECT_NEAR(e.mean[c], difference[c], 1e-15);
      EXPECT_NEAR(e.worst_case[c], e.half_width[c] + std::abs(difference[c]), 1e-15);
    }
  }
}

/// Sources of magnitude zero change no figure of the workspace, but for rounding.
TEST(Workspace, IsUnchangedBySourcesOfMagnitudeZero) {
  Dice dice(18);
  const Chain chain = make_chain(testing::random_robot(dice, {.joints = 3, .mimic = 0}), "", "");
  OperationalModel model = model_of(chain, testing::random_transmission(dice, chain, 1e-4, 1e-3, true));
  const Filter filter = cascade(1, 2);
  Configurations c{SamplingMethod::random, 200, 1, std::vector<Limits>(3, Limits{-2, 2})};
  const Workspace without = workspace(model, {norms(filter)}, c);
  model.sources = {{IndependentError::Where::joint, 1}, {IndependentError::Where::encoder, 2}};
  const Workspace with = workspace(model, {norms(filter)}, c);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(with.coordinates[i].sigma.p95, without.coordinates[i].sigma.p95);
    EXPECT_DOUBLE_EQ(with.coordinates[i].worst_case_rigorous.max,
                     without.coordinates[i].worst_case_rigorous.max);
    EXPECT_NEAR(with.derivatives[0][i].sigma->mean / without.derivatives[0][i].sigma->mean, 1, 1e-14);
    EXPECT_NEAR(with.derivatives[0][i].worst_case.max / without.derivatives[0][i].worst_case.max, 1, 1e-14);
    EXPECT_TRUE(with.coordinates[i].share.isApprox(without.coordinates[i].share, 1e-14));
    EXPECT_TRUE(
        with.coordinates[i].share_worst_case.isApprox(without.coordinates[i].share_worst_case, 1e-14));
  }
  const double h2 = norms(filter).h2;
  EXPECT_TRUE(with.filtered[0].mean_covariance.isApprox(h2 * h2 * without.mean_covariance, 1e-14));
}

}  // namespace
}  // namespace qerr
