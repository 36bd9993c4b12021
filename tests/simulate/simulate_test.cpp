#include "qerr/simulate/simulate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kinematics/inverse_dynamics.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/random_chain.hpp"
#include "support/simulate_experiment.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;
using testing::expect_same;
using testing::Experiment;

using std::numbers::pi;

/// A random robot whose encoders pass 30 to 100 counts a sample at their fastest, at incommensurable
/// frequencies.
Experiment random_experiment(Dice& dice, std::size_t joints, double slowest = 30) {
  Experiment e;
  e.model.chain = make_chain(random_robot(dice, ChainMix{joints, 0.2, 0.15}), "", "");
  e.model.transmission = testing::random_transmission(dice, e.model.chain, 1e-5, 1e-4, dice.chance(0.5));
  e.model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z, Coordinate::rx};
  e.filters = {cascade(1, 1), cascade(2, 2)};
  for (const Filter& f : e.filters) e.norms.push_back(norms(f));
  e.motion = {1000, 1.0, {}, {}, {}};
  const Eigen::VectorXd steps = resolutions(e.model.transmission);
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    const double frequency = dice.between(1, 3), rate = 2 * pi * frequency / e.motion.sample_rate;
    JointMotion joint;
    joint.center = dice.between(-1, 1);
    joint.sines = {{steps[i] * dice.between(slowest, 100) / rate, frequency, dice.between(0, 6)}};
    e.motion.joints.push_back(joint);
  }
  return e;
}

SimulationOptions runs(std::uint64_t count, std::uint64_t seed = 1) {
  SimulationOptions options;
  options.runs = count;
  options.random_phase = true;
  options.seed = seed;
  return options;
}

TEST(Simulate, AgreesWithTheTheoryOnRandomRobots) {
  Dice dice(11);
  for (int robot = 0; robot < 6; ++robot) {
    const Experiment e = random_experiment(dice, 2 + static_cast<std::size_t>(robot) % 6);
    const Simulation s = run(e, runs(48, static_cast<std::uint64_t>(robot)));
    for (std::size_t f = 0; f < s.results.size(); ++f)
      for (const SimulatedSignal& r : s.results[f]) {
        if (r.sigma_ipqn_path == 0) continue;
        EXPECT_NEAR(r.sigma_simulated / r.sigma_ipqn_path, 1, f == 0 ? 0.03 : 0.05) << robot << ' ' << f;
        EXPECT_NEAR(r.sigma_simulated / r.sigma_exact, 1, 0.03) << robot << ' ' << f;
        EXPECT_LE(r.sigma_lower, r.sigma_simulated);
        EXPECT_GE(r.sigma_upper, r.sigma_simulated);
      }
  }
}

TEST(Simulate, NeverExceedsTheWorstCaseAlongThePath) {
  Dice dice(12);
  for (int robot = 0; robot < 12; ++robot) {
    Experiment e = random_experiment(dice, 1 + static_cast<std::size_t>(robot) % 7, 0.01);
    e.motion.duration = 0.3;
    e.motion.settling = 0;  // the transient too
    // Including coarse encoders, for which the second order matters.
    for (Encoder& encoder : e.model.transmission.encoders)
      encoder.resolution *= std::pow(10, dice.between(0, 3));
    SimulationOptions options = runs(4, static_cast<std::uint64_t>(robot));
    options.random_phase = robot % 2 == 0;
    const Simulation simulation = run(e, options);
    for (std::size_t f = 0; f < simulation.results.size(); ++f) {
      // Kinematics in double have errors of 1e-15 m, which the filter multiplies by its l1 norm.
      const double rounding = 2e-15 * (f == 0 ? 1 : e.norms[f - 1].l1.upper);
      for (const SimulatedSignal& r : simulation.results[f])
        EXPECT_LE(r.peak_simulated, r.worst_case_path * (1 + 1e-9) + rounding) << robot;
    }
  }
}

TEST(Simulate, LadderLeadsFromTheCentreToTheSimulation) {
  Dice dice(13);
  const Experiment e = random_experiment(dice, 5);
  for (const auto& output : run(e, runs(3)).results)
    for (const SimulatedSignal& r : output) {
      const Ladder& l = r.ladder;
      EXPECT_NEAR(r.sigma_ipqn * l.varying_jacobian * l.joint_error * l.correlated_joints * l.nonlinear,
                  r.sigma_simulated, 1e-12 * r.sigma_simulated);
      EXPECT_NEAR(l.nonlinear, 1, 1e-3);
    }
}

TEST(Simulate, DoesNotDependOnTheThreads) {
  Dice dice(14);
  const Experiment e = random_experiment(dice, 4);
  SimulationOptions options = runs(70);
  options.threads = 1;
  const Simulation one = run(e, options);
  for (const unsigned threads : {2U, 3U}) {
    options.threads = threads;
    expect_same(one, run(e, options));
  }
}

/// Two prismatic joints along x: x is their sum, with a constant Jacobian.
Experiment two_slides(double offset_in_quanta) {
  Experiment e;
  ChainJoint slide;
  slide.prismatic = true;
  slide.axis = Eigen::Vector3d::UnitX();
  slide.name = "first";
  e.model.chain.joints.push_back(slide);
  slide.name = "second";
  slide.coordinate = 1;
  e.model.chain.joints.push_back(slide);
  e.model.chain.independent = {{"first", JointType::prismatic, {}, true},
                               {"second", JointType::prismatic, {}, true}};
  e.model.transmission = {{{1e-3}, {1e-3}}, Eigen::Matrix2d::Identity()};
  e.model.coordinates = {Coordinate::x};
  e.motion = {1000, 40, 0, {}, {}};
  for (const double offset : {0.0, offset_in_quanta * 1e-3})
    e.motion.joints.push_back({offset + 0.2e-3, 0, {{0.1, 0.3137, 0}}, {}});
  return e;
}

TEST(Simulate, JointsInPhaseHaveTheCorrelationOfTheirOffset) {
  // Identical motions, delta quanta apart: correlation 1 - 6 delta + 6 delta^2 (theory.md, section VI).
  for (const double delta : {0.0, 0.1, 0.25, 0.5, 0.8}) {
    const SimulatedSignal r = run(two_slides(delta), {}).results[0][0];
    const double correlation = 1 - 6 * delta + 6 * delta * delta;
    EXPECT_NEAR(r.ladder.correlated_joints, std::sqrt(1 + correlation), 0.01) << delta;
    EXPECT_NEAR(r.ladder.nonlinear, 1, 1e-12);
    EXPECT_NEAR(r.ladder.varying_jacobian, 1, 1e-12);
    EXPECT_NEAR(r.ladder.joint_error, 1, 0.01);
  }
}

TEST(Simulate, AConstantErrorHasNoTransientAndDoesNotReduceAccuracy) {
  Experiment e = two_slides(0.3);
  e.filters = {cascade(1, 2), cascade(2, 3)};
  for (const Filter& f : e.filters) e.norms.push_back(norms(f));
  e.motion.duration = 4;
  const double offset = 10;  // ten thousand counts; a power of ten makes the path no rounder
  const Simulation ideal = run(e, {});
  const Simulation off =
      simulate(e.model, e.filters, e.norms, e.motion, {{"offset", "first", {{"offset", offset}}, {}}}, {});
  for (std::size_t f = 0; f < ideal.results.size(); ++f)
    EXPECT_NEAR(off.results[f][0].sigma_simulated / ideal.results[f][0].sigma_simulated, 1, 1e-6) << f;
  EXPECT_NEAR(off.results[0][0].mean_simulated - ideal.results[0][0].mean_simulated, offset, 1e-9);
}

TEST(Simulate, UsesEveryNthSampleForASlowerFilter) {
  Experiment e = two_slides(0.3);
  Experiment slow = e;
  e.motion.sample_rate = 4000;
  for (Experiment* x : {&e, &slow}) {
    x->filters = {cascade(1, 1)};
    x->norms = {norms(x->filters[0])};
    x->motion.settling = 1;
  }
  const SimulatedSignal fast_motion = run(e, {}).results[1][0], own_rate = run(slow, {}).results[1][0];
  EXPECT_NEAR(fast_motion.sigma_simulated / own_rate.sigma_simulated, 1, 1e-9);
  e.motion.sample_rate = 1500;
  EXPECT_THROW(run(e, {}), Error);
}

TEST(Simulate, ReportsTheSamplesOfItsFirstRunInOrder) {
  Dice dice(15);
  const Experiment e = random_experiment(dice, 3);
  SimulationOptions options;
  std::uint64_t next = 0;
  double worst = 0;
  options.visit = [&](const Reading& r) {
    EXPECT_EQ(r.index, next++);
    worst = std::max(
        worst,
        ((r.measured - r.encoder).array().abs() / resolutions(e.model.transmission).array()).maxCoeff());
  };
  const Simulation s = run(e, options);
  EXPECT_EQ(next, s.samples);
  EXPECT_LE(worst, 1 + 1e-9);  // `down` errs by a whole count
  EXPECT_GT(worst, 0.4);
}

TEST(Simulate, SigmaOfManyRunsHasAnIntervalThatContainsTheTruth) {
  // The joint error of a fast motion has sigma = Delta/sqrt(12); at most 6 of 40 intervals of 95 %
  // may miss it (probability of more: 0.2 %), and more runs narrow them.
  Experiment e = two_slides(0);
  e.motion.duration = 0.5;
  e.motion.joints[1].sines[0].frequency = 0.5;
  int missed = 0;
  double width = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const SimulatedSignal r = run(e, runs(30, seed)).results[0][0];
    const double truth = 1e-3 * std::sqrt(2 / 12.0);
    if (r.sigma_lower > truth || r.sigma_upper < truth) ++missed;
    width += r.sigma_upper - r.sigma_lower;
  }
  EXPECT_LE(missed, 6);
  // Few runs give wide intervals: at most 15 of 120 intervals between three runs may miss (0.1 %).
  int few_missed = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const SimulatedSignal r = run(e, runs(3, 1000 + seed)).results[0][0];
    const double truth = 1e-3 * std::sqrt(2 / 12.0);
    if (r.sigma_lower > truth || r.sigma_upper < truth) ++few_missed;
  }
  EXPECT_LE(few_missed, 15);
  const SimulatedSignal many = run(e, runs(1200)).results[0][0];  // more than there are blocks to keep
  EXPECT_LT(many.sigma_upper - many.sigma_lower, width / 40 / 3);
}

}  // namespace
}  // namespace qerr
