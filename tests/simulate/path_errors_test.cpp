#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "simulate/run.hpp"
#include "support/design_filter.hpp"
#include "support/random_chain.hpp"
#include "support/reference_simulation.hpp"
#include "support/simulate_experiment.hpp"

/// The kernels of a simulation against the scalar functions, sample by sample.
namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

const std::vector<Coordinate> everything{Coordinate::x,    Coordinate::y,     Coordinate::z,
                                         Coordinate::rx,   Coordinate::ry,    Coordinate::rz,
                                         Coordinate::roll, Coordinate::pitch, Coordinate::yaw};

OperationalModel random_model(Dice& dice, std::size_t joints, double finest = 1e-5, double coarsest = 1e-3) {
  OperationalModel model;
  model.chain = make_chain(random_robot(dice, ChainMix{joints}), "", "");
  model.transmission = testing::random_transmission(dice, model.chain, finest, coarsest, dice.chance(0.5));
  model.coordinates = everything;
  return model;
}

/// Errors at a joint, at an encoder and of an origin.
std::vector<IndependentError> random_sources(Dice& dice, const Chain& chain) {
  std::vector<IndependentError> sources;
  using Where = IndependentError::Where;
  for (const Where where : {Where::joint, Where::encoder, Where::origin, Where::origin}) {
    IndependentError s{where, dice.below(chain.independent.size()), dice.below(chain.joints.size()),
                       dice.direction()};
    s.mean = dice.between(-1e-3, 1e-3);
    s.half_width = dice.between(0, 1e-3);
    sources.push_back(s);
  }
  return sources;
}

Motion random_sines(Dice& dice, std::size_t joints, double seconds) {
  Motion motion{1000, seconds, {}, {}, {}};
  for (std::size_t i = 0; i < joints; ++i) {
    JointMotion joint{dice.between(-1, 1), dice.chance(0.3) ? dice.between(-1, 1) : 0, {}, {}};
    for (std::size_t k = dice.below(3); k <= 2; ++k)
      joint.sines.push_back({dice.between(0, 0.5), dice.between(0.3, 7), dice.between(-4, 4)});
    motion.joints.push_back(joint);
  }
  return motion;
}

/// The scale of rounding errors of a pose, in m or rad.
double size_of(const Chain& chain) {
  double sum = 1 + chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) sum += 1 + joint.origin.translation().norm();
  return sum;
}

/// Compares every channel of every instant of a batch, and the largest bounds, with the scalar functions.
void expect_scalar_errors(Dice& dice, const OperationalModel& model, const Chain& built, const Motion& motion,
                          std::uint64_t batch, InstructionSet set) {
  const auto n = static_cast<Eigen::Index>(model.transmission.encoders.size());
  const auto m = static_cast<Eigen::Index>(model.coordinates.size());
  Sensing sensing(model, motion, {}, {dice.vector(n, -1e-3, 1e-3)}, set);
  const Eigen::VectorXd center_mean = dice.vector(m, -1e-3, 1e-3);
  PathErrors errors(model, built, center_mean, set);
  PathBatch path(motion, set);
  path.at(batch * batch_size, batch_size);
  const SensedBatch& batch_of_instants = sensing.sense(path);
  if (dice.chance(0.5)) errors.share(path);
  errors(batch_of_instants);
  // A position of 1e6 rad has a rounding error of 1e-10 rad.
  const double largest_angle =
      Eigen::Map<const Eigen::ArrayXd>(batch_of_instants.joint, n * 64).abs().maxCoeff();
  const double in_tip_axes = model.frame == CoordinateFrame::tip ? 4 : 1;  // which have errors of their own
  const double tolerance = in_tip_axes * (3e-15 + 1e-14 * largest_angle) * size_of(model.chain);
  const double relative = 1e-12 + 3e-15 * largest_angle;
  Eigen::ArrayXd rigorous = Eigen::ArrayXd::Zero(m), deviation = rigorous, variance = rigorous;
  for (std::size_t i = 0; i < batch_size; ++i) {
    const Reading& now = sensing.reading(i);
    const OperationalError theory = operational_error(model, now.joint);
    const double worst = 1 / std::max(theory.cosine_of_pitch, 1e-3);
    const Eigen::VectorXd exact =
        testing::tip_error(model.coordinates, forward_kinematics(model.chain, now.estimate),
                           forward_kinematics(built, now.joint), model.frame);
    const double* const row = errors.rows() + i * errors.width();
    for (Eigen::Index c = 0; c < m; ++c) {
      const double slack = tolerance * (c >= 6 ? worst * worst : 1);
      EXPECT_NEAR(std::remainder(row[c] - exact[c], 6.283185307179586), 0, slack) << "coordinate " << c;
      double linear = 0;
      for (Eigen::Index e = 0; e < n; ++e) {
        const double part = theory.weighted(c, e) * (now.measured[e] - now.encoder[e]) /
                            model.transmission.encoders[static_cast<std::size_t>(e)].resolution;
        linear += part;
        EXPECT_NEAR(row[m * (2 + e) + c], part, slack) << "encoder " << e << ", coordinate " << c;
      }
      EXPECT_NEAR(row[m + c], linear, slack);
      EXPECT_NEAR(row[m * (2 + n) + c], theory.mean[c], slack);
    }
    variance += theory.weighted.rowwise().squaredNorm().array();
    rigorous = rigorous.max(theory.rigorous.array());
    deviation = deviation.max(theory.rigorous.array() - theory.mean.array().abs() +
                              (theory.mean - center_mean).array().abs());
  }
  const auto variance_in = [&](std::size_t from, std::size_t to) {
    Eigen::ArrayXd sums(m);
    for (Eigen::Index c = 0; c < m; ++c) sums[c] = errors.variance(c, from, to);
    return sums;
  };
  const auto expect_variance = [&](const Eigen::ArrayXd& of_lanes) {
    EXPECT_LT((of_lanes - variance).abs().maxCoeff(), relative * variance.maxCoeff());
  };
  expect_variance(variance_in(0, batch_size));
  expect_variance(variance_in(0, 13) + variance_in(13, 50) + variance_in(50, batch_size));
  const Eigen::ArrayXXd rows =
      Eigen::Map<const Eigen::ArrayXXd>(errors.rows(), static_cast<Eigen::Index>(errors.width()), batch_size);
  RunStatistics statistics(m * (3 + n), m, errors.width(), 1, select_kernels<SimulationKernels>(set));
  statistics.add(errors.rows(), errors.width(), batch_size, 0);
  statistics.finish();
  for (Eigen::Index k = 0; k < m * (3 + n); ++k) {
    const double mean = rows.row(k).mean(), squares = (rows.row(k) - mean).square().mean();
    EXPECT_NEAR(statistics.mean(k), mean, 1e-12 * rows.row(k).abs().maxCoeff());
    EXPECT_NEAR(statistics.variance(k), squares, 1e-11 * squares + 1e-26);
    if (k < m) {
      EXPECT_EQ(statistics.peak(k), rows.row(k).abs().maxCoeff());
    }
  }
  EXPECT_LT((errors.rigorous().array() - rigorous).head(6).abs().maxCoeff(), tolerance);
  EXPECT_LT((errors.deviation().array() - deviation).head(6).abs().maxCoeff(), tolerance);
  EXPECT_EQ(errors.rigorous()[8], std::numeric_limits<double>::infinity());
}

/// A model with all features of the kernels: its first encoder rounds down, so that the error has a mean.
OperationalModel full_model(Dice& dice, std::size_t joints, bool sources) {
  OperationalModel model = random_model(dice, joints);
  model.transmission.encoders[0].rounding = Rounding::down;
  if (sources) model.sources = random_sources(dice, model.chain);
  if (joints % 3 == 0) model.frame = CoordinateFrame::tip;
  return model;
}

TEST(PathErrors, AreThoseOfTheScalarFunctionsOnRandomChains) {
  Dice dice(41);
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t trial = 0; trial < 40; ++trial) {
      SCOPED_TRACE(std::string(name_of(set)) + ", trial " + std::to_string(trial));
      const OperationalModel model = full_model(dice, 1 + trial % 14, trial % 2 == 1);
      const Motion motion = random_sines(dice, model.chain.independent.size(), 1);
      expect_scalar_errors(dice, model, model.chain, motion, trial, set);
    }
}

TEST(PathErrors, OfARobotWithGeometricErrorsReferToItsTrueTip) {
  Dice dice(42);
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t trial = 0; trial < 10; ++trial) {
      SCOPED_TRACE(std::string(name_of(set)) + ", trial " + std::to_string(trial));
      const OperationalModel model = full_model(dice, 2 + trial % 7, true);
      Chain built = model.chain;
      for (ChainJoint& joint : built.joints) joint.origin.pretranslate(0.1 * dice.direction());
      expect_scalar_errors(dice, model, built, random_sines(dice, model.chain.independent.size(), 1), 3, set);
    }
}

// Errors of radians: beyond the series of small angles.
TEST(PathErrors, MayBeLarge) {
  Dice dice(43);
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t trial = 0; trial < 10; ++trial) {
      SCOPED_TRACE(std::string(name_of(set)) + ", trial " + std::to_string(trial));
      OperationalModel model = full_model(dice, 2 + trial % 7, false);
      for (Encoder& encoder : model.transmission.encoders) encoder.resolution = dice.between(0.02, 2);
      expect_scalar_errors(dice, model, model.chain, random_sines(dice, model.chain.independent.size(), 1), 3,
                           set);
    }
}

// A joint that has rotated for hours; and sines of as many revolutions.
TEST(PathErrors, HoldForLargeAngles) {
  Dice dice(44);
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t trial = 0; trial < 6; ++trial) {
      SCOPED_TRACE(std::string(name_of(set)) + ", trial " + std::to_string(trial));
      const OperationalModel model = full_model(dice, 2 + trial, true);
      Motion motion = random_sines(dice, model.chain.independent.size(), 1);
      for (JointMotion& joint : motion.joints)
        if (trial % 2 == 0) joint.velocity = 3e6;
      expect_scalar_errors(dice, model, model.chain, motion, trial % 2 == 0 ? 40 : 40'000'000, set);
    }
}

struct PathExperiment {
  OperationalModel model;
  std::vector<Filter> filters;
  std::vector<Norms> norms;
  Motion motion;
  std::vector<Effect> effects;
};

Simulation run(const PathExperiment& e, const SimulationOptions& options = {}) {
  return simulate(e.model, e.filters, e.norms, e.motion, e.effects, options);
}

/// Compares every figure of a run with that of the scalar reference.
void expect_scalar_run(const PathExperiment& e, InstructionSet set) {
  SimulationOptions options;
  options.instructions = set;
  const Simulation s = run(e, options);
  const auto n = static_cast<Eigen::Index>(e.model.transmission.encoders.size());
  const testing::ReferenceRun r = testing::reference_run(
      e.model, e.filters, e.motion, e.effects, {Eigen::VectorXd::Zero(n), random_bits(1, 0, 0)}, s.settling);
  const auto m = static_cast<Eigen::Index>(e.model.coordinates.size());
  for (std::size_t f = 0; f < s.results.size(); ++f)
    for (Eigen::Index c = 0; c < m; ++c) {
      SCOPED_TRACE("output " + std::to_string(f) + ", coordinate " + std::to_string(c));
      const SimulatedSignal& ours = s.results[f][static_cast<std::size_t>(c)];
      const testing::ReferenceOutput& theirs = r.outputs[f];
      const double sigma = theirs.sigma[c], peak = theirs.peak[c];
      // A filter multiplies the rounding errors of the pose by its l1 norm.
      const double pose = 1e-15 * size_of(e.model.chain) * (f == 0 ? 1 : e.norms[f - 1].l1.upper);
      const double rounding = 1e-11 * std::max(sigma, std::abs(theirs.mean[c])) + pose;
      EXPECT_NEAR(ours.sigma_simulated, sigma, rounding);
      EXPECT_NEAR(ours.mean_simulated, theirs.mean[c], rounding);
      EXPECT_NEAR(ours.peak_simulated, peak, 1e-11 * peak + 3 * pose);
      double parts = 0;
      for (Eigen::Index i = 0; i < n; ++i) parts += std::pow(theirs.sigma[m * (2 + i) + c], 2);
      if (parts > pose * pose * 1e20) {
        EXPECT_NEAR(ours.ladder.nonlinear * theirs.sigma[m + c] / sigma, 1, 1e-10);
        EXPECT_NEAR(ours.ladder.correlated_joints * std::sqrt(parts) / theirs.sigma[m + c], 1, 1e-10);
      }
      if (f > 0) continue;
      EXPECT_NEAR(ours.worst_case_path, r.rigorous[c], 1e-12 * r.rigorous[c]);
      EXPECT_NEAR(ours.sigma_ipqn_path, r.path_sigma[c], 1e-12 * r.path_sigma[c]);
    }
}

PathExperiment random_path_experiment(Dice& dice, std::size_t joints, double seconds) {
  PathExperiment e;
  e.model = random_model(dice, joints, 1e-4, 1e-2);
  e.model.coordinates.resize(6);
  for (Encoder& encoder : e.model.transmission.encoders) encoder.rounding = Rounding::nearest;
  e.filters = {cascade(1, 1), design_filter("butterworth", 2, 500, 2, 50),
               design_filter("first_order", 1, 1000.0 / 7, 1, 20)};
  for (const Filter& f : e.filters) e.norms.push_back(norms(f));
  e.motion = random_sines(dice, e.model.chain.independent.size(), seconds);
  return e;
}

// Records that end in the middle of a batch, settle there, and filters that take every second and every
// seventh sample.
TEST(Simulate, EqualsTheScalarSimulationAtAllBoundariesOfBatches) {
  Dice dice(46);
  for (const InstructionSet set : available_instruction_sets())
    for (const std::uint64_t samples : {1, 2, 63, 64, 65, 128, 200, 1000})
      for (const double settling : {0.0, 1.0, 37.0, 64.0, 65.0, 150.0}) {
        if (settling + 14 >= static_cast<double>(samples) && settling > 0) continue;
        SCOPED_TRACE(std::string(name_of(set)) + ", " + std::to_string(samples) + " samples, settling " +
                     std::to_string(settling));
        PathExperiment e = random_path_experiment(dice, 1 + samples % 5, static_cast<double>(samples) / 1000);
        e.motion.settling = settling / 1000;
        expect_scalar_run(e, set);
      }
}

TEST(Simulate, EqualsTheScalarSimulationWithEffectsOfEveryStage) {
  Dice dice(47);
  for (const InstructionSet set : available_instruction_sets())
    for (std::size_t trial = 0; trial < 6; ++trial) {
      SCOPED_TRACE(std::string(name_of(set)) + ", trial " + std::to_string(trial));
      PathExperiment e = random_path_experiment(dice, 5, 0.7);
      const auto joint = [&] {
        return e.model.chain.independent[dice.below(e.model.chain.independent.size())].name;
      };
      e.effects = {{"latency", joint(), {{"latency", 2e-3}}, {}},
                   {"backlash", joint(), {{"gap", 3e-3}}, {}},
                   {"noise", joint(), {{"sigma", 1e-3}}, {}},
                   {"missed_counts", joint(), {{"counts", 5}, {"time", 0.3}}, {}},
                   {"geometry", e.model.chain.joints.back().name, {{"length", 1e-3}}, {{"axis", "y"}}}};
      expect_scalar_run(e, set);
    }
}

TEST(Simulate, OfManyRunsIsTheSameForAnyNumberOfThreadsOnEverySet) {
  Dice dice(48);
  const PathExperiment e = random_path_experiment(dice, 6, 0.333);
  for (const InstructionSet set : available_instruction_sets()) {
    SimulationOptions options;
    options.runs = 130;
    options.random_phase = true;
    options.instructions = set;
    options.threads = 1;
    const Simulation one = run(e, options);
    for (const unsigned threads : {2u, 5u}) {
      options.threads = threads;
      testing::expect_same(one, run(e, options));
    }
  }
}

TEST(Simulate, IsAccurateWithALargeMean) {
  Dice dice(49);
  PathExperiment e = random_path_experiment(dice, 4, 2.0);
  const std::string joint = e.model.chain.independent[0].name;
  e.effects = {{"offset", joint, {{"offset", 0.7}}, {}}};
  for (const InstructionSet set : available_instruction_sets()) expect_scalar_run(e, set);
}

}  // namespace
}  // namespace qerr
