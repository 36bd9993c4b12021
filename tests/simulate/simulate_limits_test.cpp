#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "filter/norms/autocorrelation.hpp"
#include "support/design_filter.hpp"
#include "support/simulate_experiment.hpp"

/// Simulation at singularities, where the theory is unbounded or not available.
namespace qerr {
namespace {

using testing::Experiment;

using std::numbers::pi;

/// A wrist that rotates about z, then about y around a mean pitch, and a third joint at rest. For a mean
/// pitch of 90 deg its first sample and some later ones are at the gimbal lock.
Experiment wrist(double pitch) {
  Experiment e;
  for (const auto& [name, axis] : {std::pair{"yaw", Eigen::Vector3d(0, 0, 1)},
                                   {"pitch", Eigen::Vector3d(0, 1, 0)},
                                   {"rest", Eigen::Vector3d(0, 1, 0)}}) {
    ChainJoint joint;
    joint.name = name;
    joint.axis = axis;
    joint.coordinate = e.model.chain.joints.size();
    e.model.chain.joints.push_back(joint);
    e.model.chain.independent.push_back({name, JointType::revolute, {}, true});
  }
  e.model.chain.tip_offset.translation() = Eigen::Vector3d(0.4, 0, 0);
  e.model.transmission = {{{4e-4}, {4e-4}, {4e-4}}, Eigen::Matrix3d::Identity()};
  e.model.coordinates = {Coordinate::x, Coordinate::roll, Coordinate::pitch, Coordinate::yaw};
  e.filters = {cascade(1, 2)};
  e.norms = {norms(e.filters[0])};
  e.motion = {1000, 2, 0, {}, {}};
  e.motion.joints = {{0.2, 0, {{0.8, 0.5, 0}}, {}}, {pitch, 0, {{0.5, 2, 0}}, {}}, {0, 0, {}, {}}};
  return e;
}

TEST(Simulate, AtTheGimbalLockTheoryOfEulerAnglesIsUnboundedAndTheSimulationIsNot) {
  const Simulation s = run(wrist(0.5 * pi));
  for (const auto& row : s.results)
    for (const std::size_t c : {1, 2, 3}) {
      const SimulatedSignal& r = row[c];
      for (const double theory :
           {r.sigma_ipqn, r.sigma_ipqn_path, r.sigma_exact, r.worst_case, r.worst_case_path})
        EXPECT_EQ(theory, std::numeric_limits<double>::infinity()) << c;
      for (const double factor :
           {r.ladder.varying_jacobian, r.ladder.joint_error, r.ladder.correlated_joints, r.ladder.nonlinear})
        EXPECT_TRUE(std::isnan(factor)) << c;
      EXPECT_TRUE(std::isfinite(r.sigma_upper) && std::isfinite(r.mean_simulated)) << c;
      if (c != 3) continue;  // pitch is known well; this wrist has no roll but a rounding error
      EXPECT_GT(r.sigma_simulated, 0.01);
      EXPECT_GT(r.sigma_upper, 1.05 * r.sigma_simulated) << "an interval is known all the same";
      EXPECT_LT(r.sigma_lower, 0.95 * r.sigma_simulated);
    }
}

TEST(Simulate, TheGimbalLockDoesNotChangeTheOtherCoordinates) {
  const Experiment lock = wrist(0.5 * pi);
  Experiment without = lock;
  without.model.coordinates = {Coordinate::x};
  const Simulation all = run(lock), some = run(without);
  for (std::size_t f = 0; f < all.results.size(); ++f) {
    const SimulatedSignal &a = all.results[f][0], &b = some.results[f][0];
    EXPECT_EQ(a.sigma_simulated, b.sigma_simulated);
    EXPECT_DOUBLE_EQ(a.sigma_upper, b.sigma_upper);
    EXPECT_EQ(a.sigma_exact, b.sigma_exact);
    EXPECT_EQ(a.ladder.joint_error, b.ladder.joint_error);
    EXPECT_EQ(a.ladder.nonlinear, b.ladder.nonlinear);
  }
}

TEST(Simulate, HasTheExactSigmaOfAFilterWithALongMemory) {
  Experiment e = wrist(0);
  e.filters.push_back(cascade(1, 1, 1e-4));  // remembers hours
  e.norms.push_back(norms(e.filters[1]));
  ASSERT_FALSE(autocorrelation_within(e.filters[1]));
  const Simulation s = run(e);
  const SimulatedSignal &quick = s.results[1][0], &slow = s.results[2][0];
  EXPECT_TRUE(std::isfinite(quick.sigma_exact));
  EXPECT_NEAR(slow.sigma_simulated / slow.sigma_exact, 1, 0.2);
  EXPECT_DOUBLE_EQ(slow.sigma_ipqn / quick.sigma_ipqn, e.norms[1].h2 / e.norms[0].h2);
  EXPECT_GT(slow.sigma_simulated, 0);
  EXPECT_LE(slow.peak_simulated, slow.worst_case_path);
  EXPECT_TRUE(std::isfinite(slow.ladder.nonlinear));
}

// The ratio of the rates counts samples: beyond 2^53 it is no longer a count.
TEST(Simulate, RefusesRatesWhoseRatioIsNoExactCount) {
  Experiment e = wrist(0);
  for (const double rate : {1e22, 1e300}) {
    e.motion.sample_rate = rate;
    e.motion.duration = 1 / rate;
    EXPECT_EQ(refusal([&] { run(e); }).key, "motion.sample_rate") << rate;
  }
}

}  // namespace
}  // namespace qerr
