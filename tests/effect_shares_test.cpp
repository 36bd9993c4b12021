#include "qerr/bound/effect_shares.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "design_filter.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/filter/filter_bank.hpp"
#include "qerr/kinematics/inverse_dynamics.hpp"
#include "qerr/simulate/simulate.hpp"
#include "qerr/simulate/usage.hpp"
#include "random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

constexpr double pi = std::numbers::pi;

OperationalModel model_of(const Chain& chain, const Transmission& transmission) {
  return {chain, transmission, {Coordinate::x, Coordinate::y, Coordinate::z}, {}};
}

/// One revolute joint, 0.7 m from the tip, with a quadrature encoder of 2000 counts behind a gear of 10.
OperationalModel one_joint() {
  ChainJoint joint;
  joint.name = "elbow";
  Chain chain;
  chain.joints = {joint};
  chain.independent = {{"elbow", JointType::revolute, {}, true}};
  chain.tip_offset.translation() = Eigen::Vector3d(0.7, 0, 0);
  Encoder encoder;
  encoder.resolution = 2 * pi / 20000;
  encoder.shaft_ratio = 10;
  return model_of(chain, {{encoder}, Eigen::MatrixXd::Identity(1, 1)});
}

Motion random_motion(Dice& dice, std::size_t joints, double seconds = 6) {
  Motion motion{500, seconds, 0.0, {}, {}};
  for (std::size_t i = 0; i < joints; ++i)
    motion.joints.push_back({dice.between(-1, 1),
                             0,
                             {{dice.between(0.2, 1), dice.between(0.3, 1), dice.between(0, 6)},
                              {dice.between(0, 0.2), dice.between(1, 3), dice.between(0, 6)}},
                             {}});
  return motion;
}

/// Every row's parameters at random, of a size that shows.
Effect random_effect(Dice& dice, const EffectKind& kind, const std::string& joint, const Encoder& encoder) {
  Effect e{std::string(kind.name), joint, {}, {}};
  const double step = encoder.resolution;
  for (const Parameter& p : kind.parameters) {
    const std::string name(p.name);
    if (p.kind == Kind::choice) {
      const auto words = choices_of(p);
      e.choices[name] = words[dice.below(words.size())];
      continue;
    }
    const double sign = dice.chance(0.5) ? 1 : -1;
    double value = dice.between(0, 20 * step);  // amplitudes, gaps, widths, steps
    if (name == "offset" || (name == "amplitude" && p.least < 0)) value *= sign;
    if (name == "scale" || name == "rate") value = sign * dice.between(0, 1e-3);
    if (name == "phase") value = dice.between(-1.4, 1.4);
    if (name == "order") value = p.most == 1 ? 1 : dice.between(0.5, 60);
    if (name == "offset_sin" || name == "offset_cos" || name == "gain") value = dice.between(-0.1, 0.1);
    if (name == "clipping") value = dice.between(0.5, 1);
    if (name == "counts") value = std::round(dice.between(-50, 50));
    if (name == "time" || name == "time_constant") value = dice.between(0.1, 8);
    if (name == "factor") value = dice.chance(0.5) ? dice.between(-2, 3) : sign * std::exp2(dice.below(3));
    if (name == "compliance" || name == "coefficient") value = 0;  // no load and no temperature in these runs
    if (name == "delay") value = sign * dice.between(0, 0.03);
    if (name == "sigma") value = p.dimension == dimension::time ? dice.between(0, 5e-3) : value;
    if (name == "modulus") value = std::round(dice.between(0.1, 3) / step);
    e.numbers[name] = value;
  }
  return e;
}

bool is_gaussian(const Effect& e) { return e.type == "noise" || e.type == "timing_jitter"; }

/// Largest |estimate - true| of every joint over one simulated run.
Eigen::VectorXd largest_errors(const OperationalModel& model, const Motion& motion,
                               const std::vector<Effect>& effects) {
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.chain.independent.size()));
  SimulationOptions options;
  options.threads = 1;
  options.visit = [&](const Reading& r) { largest = largest.cwiseMax((r.estimate - r.joint).cwiseAbs()); };
  simulate(model, {}, {}, motion, effects, options);
  return largest;
}

OperationalModel with_sources(OperationalModel model, const std::vector<Effect>& effects,
                              const Motion& motion, const std::vector<Filter>& filters = {}) {
  const RobotUsage usage = usage_in_motion(model, motion);
  std::vector<Norms> all;
  for (const Filter& f : filters) all.push_back(norms(f));
  model.sources = error_sources(model, effect_shares(model, effects, usage), usage, filters, all);
  return model;
}

/// Rounding of sums of many figures.
constexpr double rounding = 1e-9;

TEST(EffectShares, OfEveryRowBoundWhatASimulationShows) {
  Dice dice(11);
  for (const EffectKind& kind : effect_kinds())
    for (int trial = 0; trial < 12; ++trial) {
      OperationalModel model = one_joint();
      Encoder& encoder = model.transmission.encoders[0];
      if (dice.chance(0.3)) encoder.rounding = Rounding::down;
      if (kind.name == "subdivision_error") encoder.counts_per_period = 64;
      const Motion motion = random_motion(dice, 1);
      const Effect effect = random_effect(dice, kind, "elbow", encoder);
      const OperationalModel real = with_sources(model, {effect}, motion);
      const double bound = joint_error(real.transmission, real.sources).worst_case[0];
      const double found = largest_errors(model, motion, {effect})[0];
      const double beyond = is_gaussian(effect) ? 1.2 : 1;
      EXPECT_LE(found, bound * (1 + rounding) * beyond) << kind.name << " trial " << trial;
      // Of normal numbers 3000 go beyond four sigma in one run of six; a bound of them is what it is.
    }
}

/// A bound that is never nearly reached says little: the best of some runs uses most of it.
TEST(EffectShares, AreReached) {
  Dice dice(12);
  const std::set<std::string_view> loose{"compliance", "geometry", "reference_error", "log_rounding",
                                         "noise"};
  for (const EffectKind& kind : effect_kinds()) {
    if (loose.contains(kind.name)) continue;
    double used = 0;
    for (int trial = 0; trial < 12; ++trial) {
      OperationalModel model = one_joint();
      if (kind.name == "subdivision_error") model.transmission.encoders[0].counts_per_period = 64;
      const Motion motion = random_motion(dice, 1);
      const Effect effect = random_effect(dice, kind, "elbow", model.transmission.encoders[0]);
      const OperationalModel real = with_sources(model, {effect}, motion);
      used = std::max(used, largest_errors(model, motion, {effect})[0] /
                                joint_error(real.transmission, real.sources).worst_case[0]);
    }
    EXPECT_GT(used, kind.name == "clock_drift" ? 0.5 : 0.85) << kind.name;
  }
}

/// Mean square of estimate - true about the share's mean: that of the quantization, and sigma^2.
TEST(EffectShares, HaveTheSigmaOfTheSimulation) {
  Dice dice(19);
  for (const char* type : {"offset", "scale", "transmission_error", "subdivision_error", "state_width",
                           "missed_counts", "truncation", "backlash", "latency", "timing_jitter", "noise"}) {
    OperationalModel model = one_joint();
    Encoder& encoder = model.transmission.encoders[0];
    if (std::string(type) == "subdivision_error") encoder.counts_per_period = 64;
    const Motion motion = random_motion(dice, 1, 40);
    Effect effect = random_effect(dice, effect_kind(type), "elbow", encoder);
    if (effect.numbers.contains("order")) effect.numbers["order"] = 31.7;  // many turns of the sine
    const Share share = *effect_shares(model, {effect}, usage_in_motion(model, motion))[0].share;
    double squares = 0;
    std::uint64_t count = 0;
    SimulationOptions options;
    options.threads = 1;
    options.visit = [&](const Reading& r) {
      squares += std::pow(r.estimate[0] - r.joint[0] - share.mean, 2);
      ++count;
    };
    simulate(model, {}, {}, motion, {effect}, options);
    const double found = std::sqrt(squares / static_cast<double>(count));
    EXPECT_NEAR(found / std::hypot(encoder.resolution / std::sqrt(12.0), share.sigma), 1, 0.03) << type;
  }
}

TEST(EffectShares, AreZeroAtZeroSizeWhateverIsKnown) {
  Encoder encoder;
  encoder.resolution = 1e-4;
  encoder.rounding = Rounding::down;  // so that truncation has nothing to truncate
  for (const EffectKind& kind : effect_kinds()) {
    Effect none{std::string(kind.name), "elbow", {}, {}};
    for (const Parameter& p : kind.parameters)
      if (p.kind == Kind::number || p.kind == Kind::integer)
        none.numbers[std::string(p.name)] = p.fallback.value_or(0);
    if (kind.name == "decoding") none.numbers["factor"] = 1;
    Usage usage;
    if (kind.name == "rollover") {
      none.numbers["modulus"] = 1e9;
      usage.position = Spread{-3, 3, 0, 3};
    }
    const auto share = kind.share(none, encoder, usage);
    ASSERT_TRUE(share) << kind.name;
    EXPECT_EQ(share->mean, 0) << kind.name;
    EXPECT_EQ(share->half_width, 0) << kind.name;
    EXPECT_EQ(share->sigma, 0) << kind.name;
  }
}

TEST(EffectShares, AreEmptyWhereTheUsageLacksWhatTheyNeed) {
  Dice dice(13);
  const OperationalModel model = one_joint();
  for (const EffectKind& kind : effect_kinds()) {
    Effect e = random_effect(dice, kind, "elbow", model.transmission.encoders[0]);
    if (kind.name == "compliance") e.numbers["compliance"] = 1e-4;
    if (kind.name == "drift") e.numbers["coefficient"] = 1e-5;
    EXPECT_EQ(kind.share(e, model.transmission.encoders[0], {}).has_value(), kind.need == Need::nothing)
        << kind.name;
    EXPECT_FALSE(kind.summary.empty());
    EXPECT_FALSE(kind.typical.empty());
    EXPECT_FALSE(stage_name(kind.stage).empty());
  }
}

/// With all of them at once: each meets what those before it added.
TEST(EffectShares, AddUpForManyEffectsOnCoupledJoints) {
  Dice dice(14);
  for (int trial = 0; trial < 25; ++trial) {
    const std::size_t joints = 2 + dice.below(3);
    const Chain chain = make_chain(testing::random_robot(dice, {.joints = joints, .mimic = 0}), "", "");
    OperationalModel model = model_of(chain, testing::random_transmission(dice, chain, 1e-4, 1e-2, true));
    const Motion motion = random_motion(dice, chain.independent.size(), 3);
    std::vector<Effect> effects;
    for (int i = 0; i < 6; ++i) {
      const EffectKind& kind = effect_kinds()[dice.below(effect_kinds().size())];
      if (kind.name == "geometry" || kind.name == "noise" || kind.name == "timing_jitter") continue;
      const std::size_t joint = dice.below(joints);
      effects.push_back(
          random_effect(dice, kind, chain.independent[joint].name, model.transmission.encoders[joint]));
    }
    const OperationalModel real = with_sources(model, effects, motion);
    const Eigen::VectorXd bound = joint_error(real.transmission, real.sources).worst_case;
    const Eigen::VectorXd found = largest_errors(model, motion, effects);
    for (Eigen::Index j = 0; j < bound.size(); ++j) {
      std::string names;
      for (const Effect& e : effects) names += e.type + ' ';
      EXPECT_LE(found[j], bound[j] * (1 + rounding)) << names;
    }
  }
}

/// At the tip: nothing that is simulated lies beyond the rigorous bound along the path.
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
    for (const SimulatedSignal& signal : s.results[0]) {
      EXPECT_LE(signal.peak_simulated, signal.worst_case_path * (1 + rounding)) << trial;
      used = std::max(used, signal.peak_simulated / signal.worst_case_path);
    }
  }
  EXPECT_GT(used, 0.4);
}

/// The model believes the origin where it is not: the difference of two forward kinematics.
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
    model.sources = error_sources(model, effect_shares(model, {effect}, unknown), unknown, {}, {});
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

/// sigma of a signal behind a filter that has settled, over the rest of the record, about its mean.
double filtered_sigma(const Filter& filter, const std::vector<double>& signal, std::size_t settled) {
  FilterBank bank(filter, 1);
  Eigen::ArrayXd x(1);
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < signal.size(); ++k) {
    x[0] = signal[k];
    bank.step(x);
    if (k < settled) continue;
    sum += x[0];
    squares += x[0] * x[0];
  }
  const auto n = static_cast<double>(signal.size() - settled);
  return std::sqrt(squares / n - sum / n * (sum / n));
}

/// What of an effect's sigma the bounds say a filter lets through, beside the filter run on the effect
/// itself.
struct Passed {
  double said = 0, simulated = 0;
};

Passed passed(const Effect& effect, const Motion& motion, const Filter& filter,
              OperationalModel model = one_joint()) {
  const RobotUsage usage = usage_in_motion(model, motion);
  const Encoder& encoder = model.transmission.encoders[0];
  const EffectKind& kind = effect_kind(effect.type);
  const Share share = *kind.share(effect, encoder, usage.encoders[0]);
  const MotionPath path(motion);
  Action action = kind.action(effect, encoder, 1);
  std::vector<double> error;
  for (double k = 0; k < motion.duration * motion.sample_rate; ++k) {
    Moment moment{static_cast<std::uint64_t>(k), k / motion.sample_rate, 0, 0, 0};
    const double x = moment.joint = path.position(0, moment.time);
    error.push_back(kind.stage == Stage::clock ? path.position(0, action(moment.time, moment)) - x
                                               : action(x, moment) - x);
  }
  return {passed_by(filter, norms(filter), share, usage.encoders[0]) * share.sigma,
          filtered_sigma(filter, error, error.size() / 5)};
}

Filter velocity_filter() { return cascade(1, 2); }

TEST(PassedBy, IsTheFilterRunOnAPeriodicErrorAtConstantSpeed) {
  const Motion motion{1000, 40, {}, {{0, 0.7, {}, {}}}, {}};
  for (const double order : {1.0, 2.0, 37.3, 300.0}) {
    const Passed p = passed({"transmission_error",
                             "elbow",
                             {{"amplitude", 1e-3}, {"phase", 0.3}, {"order", order}},
                             {{"shaft", "encoder"}}},
                            motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.02) << order;
  }
}

TEST(PassedBy, IsNearTheFilterRunOnAPeriodicErrorAlongASine) {
  const Motion motion{1000, 40, {}, {{0, 0, {{1.2, 0.21, 0}}, {}}}, {}};
  for (const double order : {3.0, 20.0, 90.0}) {
    const Passed p =
        passed({"transmission_error", "elbow", {{"amplitude", 1e-3}, {"phase", 0.3}, {"order", order}}, {}},
               motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.05) << order;
  }
}

TEST(PassedBy, KnowsTheHarmonicsOfASubdivisionError) {
  OperationalModel model = one_joint();
  model.transmission.encoders[0].counts_per_period = 64;
  const Motion motion{1000, 40, {}, {{0, 0.7, {}, {}}}, {}};
  for (const double clip : {1.0, 0.65}) {
    const Passed p = passed({"subdivision_error",
                             "elbow",
                             {{"offset_sin", 0.02}, {"gain", 0.03}, {"phase", 0.05}, {"clipping", clip}},
                             {}},
                            motion, velocity_filter(), model);
    EXPECT_NEAR(p.simulated / p.said, 1, 0.02) << clip;
  }
}

TEST(PassedBy, FollowsLatencyScaleAndBacklashAlongASine) {
  for (const double frequency : {0.21, 2.5, 20.0}) {
    const Motion motion{1000, 60, {}, {{0.4, 0, {{0.3, frequency, 0.1}}, {}}}, {}};
    const double least = frequency > 10 ? 0.05 : 0.03;
    for (const Effect& effect :
         {Effect{"latency", "elbow", {{"delay", 1e-3}}, {}}, Effect{"scale", "elbow", {{"scale", 1e-3}}, {}},
          Effect{"backlash", "elbow", {{"gap", 1e-3}}, {}}}) {
      const Passed p = passed(effect, motion, velocity_filter());
      EXPECT_NEAR(p.simulated / p.said, 1, least) << effect.type << ' ' << frequency;
    }
  }
}

/// Two sines of which neither rules: mean frequencies stand for both.
TEST(PassedBy, IsNearTheFilterRunOnMotionsOfTwoSines) {
  Dice dice(20);
  for (int trial = 0; trial < 20; ++trial) {
    Motion motion = random_motion(dice, 1, 40);
    motion.sample_rate = 1000;
    for (const Effect& effect :
         {Effect{"latency", "elbow", {{"delay", 1e-3}}, {}}, Effect{"scale", "elbow", {{"scale", 1e-3}}, {}},
          Effect{"backlash", "elbow", {{"gap", 1e-3}}, {}},
          Effect{"transmission_error", "elbow", {{"amplitude", 1e-3}, {"order", 20}}, {}}}) {
      const Passed p = passed(effect, motion, velocity_filter());
      const double ratio = p.simulated / p.said;
      EXPECT_NEAR(ratio, 1, 0.1) << effect.type;
    }
  }
}

TEST(PassedBy, TakesJitterAndNoiseAsWhiteAndNothingOfConstants) {
  const Motion motion{1000, 200, {}, {{0.4, 0, {{0.3, 0.5, 0.1}}, {}}}, {}};
  for (const Effect& effect : {Effect{"noise", "elbow", {{"sigma", 1e-3}}, {}},
                               Effect{"timing_jitter", "elbow", {{"sigma", 1e-3}}, {}}}) {
    const Passed p = passed(effect, motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.03) << effect.type;
  }
  EXPECT_EQ(
      passed({"missed_counts", "elbow", {{"counts", 4}, {"time", 1}}, {}}, motion, velocity_filter()).said,
      0);
}

TEST(EffectShares, OfComplianceAreTheLoadsOfTheMotion) {
  Dice dice(17);
  OperationalModel model = one_joint();
  model.chain.joints[0].load = {3, {0.4, 0, 0}, Eigen::Vector3d(0.01, 0.02, 0.02).asDiagonal()};
  model.chain.joints[0].axis = Eigen::Vector3d::UnitY();
  const Motion motion = random_motion(dice, 1);
  const RobotUsage usage = usage_in_motion(model, motion);
  ASSERT_TRUE(usage.joints[0].effort);
  const Effect effect{"compliance", "elbow", {{"compliance", 2e-5}}, {}};
  const Share share = *effect_shares(model, {effect}, usage)[0].share;
  // A pendulum on a beam: about y gravity pulls at cos q, and 3 kg at 0.4 m with 0.02 kg m^2 must be turned.
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

TEST(Usage, FromLimitsIsSpreadEvenlyOverThem) {
  OperationalModel model = one_joint();
  model.chain.independent[0].velocity_limit = 2;
  const RobotUsage usage = usage_from_limits(model, {{-1, 3}});
  const Usage& u = usage.encoders[0];
  EXPECT_DOUBLE_EQ(u.position->middle(), 1);
  EXPECT_DOUBLE_EQ(u.position->half(), 2);
  EXPECT_DOUBLE_EQ(u.position->stray(), 2 / std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(u.velocity->rms(), 2 / std::sqrt(3.0));
  EXPECT_FALSE(u.effort);
  EXPECT_FALSE(u.duration);
  EXPECT_DOUBLE_EQ(*u.position->rate, 1);
  EXPECT_DOUBLE_EQ(*u.velocity->rate, 1);
}

/// Sources that are nothing leave every figure of the workspace as it was, to the last bit.
TEST(Workspace, WithSourcesThatAreNothingIsThatWithout) {
  Dice dice(18);
  const Chain chain = make_chain(testing::random_robot(dice, {.joints = 3, .mimic = 0}), "", "");
  OperationalModel model = model_of(chain, testing::random_transmission(dice, chain, 1e-4, 1e-3, true));
  const Filter filter = velocity_filter();
  Configurations c{SamplingMethod::random, 200, 1, std::vector<Limits>(3, Limits{-2, 2})};
  const Workspace without = workspace(model, {norms(filter)}, c);
  model.sources = {{ErrorSource::Where::joint, 1}, {ErrorSource::Where::encoder, 2}};
  const Workspace with = workspace(model, {norms(filter)}, c);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(with.coordinates[i].sigma.p95, without.coordinates[i].sigma.p95);
    EXPECT_EQ(with.coordinates[i].worst_case_rigorous.max, without.coordinates[i].worst_case_rigorous.max);
    EXPECT_NEAR(with.derivatives[0][i].sigma.mean / without.derivatives[0][i].sigma.mean, 1, 1e-14);
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
