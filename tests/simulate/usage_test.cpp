#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kinematics/inverse_dynamics.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/motion_path.hpp"
#include "support/effect_experiment.hpp"

namespace qerr {
namespace {

using testing::Dice;
using testing::one_joint;
using testing::random_motion;

TEST(Usage, FromLimitsIsUniform) {
  OperationalModel model = one_joint();
  model.chain.independent[0].velocity_limit = 2;
  const RobotUsage usage = usage_from_limits(model, {{-1, 3}});
  const Usage& u = usage.encoders[0];
  EXPECT_DOUBLE_EQ(u.position->mid_range(), 1);
  EXPECT_DOUBLE_EQ(u.position->half_width(), 2);
  EXPECT_DOUBLE_EQ(u.position->rms_about_mid_range(), 2 / std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(u.velocity->rms(), 2 / std::sqrt(3.0));
  EXPECT_FALSE(u.effort);
  EXPECT_FALSE(u.duration);
}

TEST(Usage, OfAMotionHasTheEffortsThatActOnCompliance) {
  Dice dice(17);
  OperationalModel model = one_joint();
  model.chain.joints[0].load = {3, {0.4, 0, 0}, Eigen::Vector3d(0.01, 0.02, 0.02).asDiagonal()};
  model.chain.joints[0].axis = Eigen::Vector3d::UnitY();
  const Motion motion = random_motion(dice, 1);
  const RobotUsage usage = usage_in_motion(model, motion);
  ASSERT_TRUE(usage.joints[0].effort);
  const Effect effect{"compliance", "elbow", {{"compliance", 2e-5}}, {}};
  const Share share = *effect_shares(model, {effect}, usage)[0].share;
  // A pendulum about y: gravity torque proportional to cos q, plus the inertia of 3 kg at 0.4 m and 0.02 kg
  // m^2.
  const MotionPath path(motion);
  double largest = 0;
  for (double t = 0; t < motion.duration; t += 1 / motion.sample_rate) {
    const double h = 1e-4, q = path.position(0, t);
    const double a = (path.velocity(t + h)[0] - path.velocity(t - h)[0]) / (2 * h);
    const double effort = (3 * 0.16 + 0.02) * a - 3 * standard_gravity * 0.4 * std::cos(q);
    largest = std::max(largest, std::abs(effort));
    EXPECT_LE(2e-5 * std::abs(effort), (std::abs(share.mean) + share.half_width) * (1 + 1e-4));
  }
  EXPECT_NEAR((std::abs(share.mean) + share.half_width) / (2e-5 * largest), 1, 0.01);
}

/// A profile whose acceleration jumps at samples: the effort includes the full step, not its mean.
TEST(Usage, OfAMotionHasTheEffortsOfTheSimulation) {
  OperationalModel model = one_joint();
  model.chain.joints[0].load = {3, {0.4, 0, 0}, Eigen::Vector3d(0.01, 0.02, 0.02).asDiagonal()};
  Motion motion{1000, 3, 0.0, {}, {}};
  motion.joints = {{0, 0, {}, {{1, 1, 4, 0, 0.25}, {0, 1, 4, 0, 0.25}}}};
  const Spread effort = *usage_in_motion(model, motion).joints[0].effort;
  double lower = 0, upper = 0, squares = 0;
  SimulationOptions options;
  options.visit = [&](const Reading& r) {
    lower = std::min(lower, r.effort[0]);
    upper = std::max(upper, r.effort[0]);
    squares += r.effort[0] * r.effort[0];
  };
  const Simulation s = simulate(model, {}, {}, motion, {}, options);
  // About z gravity has no torque; 3 kg at 0.4 m and 0.02 kg m^2 accelerate at 4 rad/s^2.
  EXPECT_NEAR(upper, 4 * (3 * 0.16 + 0.02), 1e-9);
  EXPECT_DOUBLE_EQ(effort.upper, upper);
  EXPECT_DOUBLE_EQ(effort.lower, lower);
  EXPECT_NEAR(effort.mean_square / (squares / static_cast<double>(s.samples)), 1, 1e-12);
}

/// A counter behind a negative gear ratio falls while the joint rises; lost counts are counts of the counter.
TEST(Reading, HasTheCountsThatTheCounterShows) {
  OperationalModel model = one_joint();
  model.transmission.encoders[0].shaft_ratio *= -1;
  const double step = model.transmission.encoders[0].resolution;
  const Motion motion{1000, 1, 0.0, {{0.2, 0.5, {}, {}}}, {}};
  SimulationOptions options;
  options.visit = [&](const Reading& r) {
    const double gained = r.time >= 0.5 ? 7 : 0;
    EXPECT_EQ(r.counts[0], gained - std::floor((0.2 + 0.5 * r.time) / step + 0.5));
    EXPECT_NEAR(r.measured[0], -step * r.counts[0], 1e-15);
  };
  simulate(model, {}, {}, motion, {{"missed_counts", "elbow", {{"counts", 7}, {"time", 0.5}}, {}}}, options);
}

}  // namespace
}  // namespace qerr
