#include "qerr/report/analysis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <sstream>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

TEST(Analysis, GivesSigmaInMotionWhereTheSpecHasOne) {
  const Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  const Analysis a = analyze(spec);
  ASSERT_EQ(a.noise_in_motion.size(), spec.filters.size());
  for (std::size_t f = 0; f < spec.filters.size(); ++f) {
    ASSERT_TRUE(a.workspace.derivatives[f][0].sigma_in_motion);
    // All encoders have the same motion, so that the coordinate's sigma scales as theirs.
    const double factor = a.noise_in_motion[f][0] * std::sqrt(12.0) / spec.filters[f].norms.h2;
    EXPECT_NEAR(a.workspace.derivatives[f][0].sigma_in_motion->max / a.workspace.derivatives[f][0].sigma->max,
                factor, 1e-9);
    EXPECT_GT(std::abs(factor - 1), 1e-3);
  }
  for (const std::string& warning : a.warnings) EXPECT_EQ(warning.find("IPQN"), std::string::npos);
}

TEST(Analysis, WarnsOfIpqnInOneSentenceWithoutAMotion) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/planar_prr/spec.yaml");
  spec.motion.reset();
  int sentences = 0;
  for (const std::string& warning : analyze(spec).warnings)
    if (warning.find("IPQN") != std::string::npos) {
      ++sentences;
      EXPECT_NE(warning.find("'velocity_first' 0.11"), std::string::npos) << warning;
      EXPECT_NE(warning.find("motion:"), std::string::npos);
    }
  EXPECT_EQ(sentences, 1);
}

TEST(Analysis, GivesNoVerdictOnARequirementThatCannotBeDecided) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  Requirement r;
  r.quantity = "velocity_1.x.sigma_in_motion";
  r.filter = 0;
  r.bound = Bound::sigma_in_motion;
  spec.requirements = {r};
  EXPECT_NO_THROW(analyze(spec));
  spec.motion->duration = 1e9;  // more samples than are evaluated
  EXPECT_THROW(analyze(spec), Error);
}

TEST(Analysis, WarnsOfADerivativeThatIsNotScaled) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  const auto suspicious = [&] { return filter_warnings(spec).size(); };
  EXPECT_EQ(suspicious(), 0u);
  for (const std::vector<double>& numerator : {std::vector<double>{1, -1}, {1e6, -2e6, 1e6}, {1e3, -500}}) {
    spec.filters[0].filter = filter_from_coefficients(numerator, {1}, 1000, 1);
    spec.filters[0].norms = norms(spec.filters[0].filter);
    EXPECT_EQ(suspicious(), 1u) << numerator[0];
  }
  spec.filters[0].filter = filter_from_coefficients({-1000, 1000}, {1}, 1000, 1);
  spec.filters[0].norms = norms(spec.filters[0].filter);
  ASSERT_EQ(suspicious(), 1u);
  EXPECT_NE(filter_warnings(spec)[0].find("sign"), std::string::npos);
}

/// A servo of 100000 counts a turn whose torque is 200 N m/rad q + 2 N m s/rad dq/dt at 1 kHz.
Spec servo(const std::string& more, const std::string& robot = "") {
  return parse_spec(
      "qerr: 1\nrobot: {joint: {name: j, type: revolute" + robot +
          "}}\nencoders: {j: {counts_per_rev: 2000, gear_ratio: 50}}\nconfigurations: {count: 10}\n"
          "filters: {torque: {sample_rate: 1 kHz, numerator: [2200, -2000], denominator: [1]" +
          more + "}}\n",
      "servo.yaml");
}

TEST(ControlLaw, HasTheUnitOfItsGainOrNone) {
  const Spec bare = servo(""), stated = servo(", unit: N m/rad"), position = servo(", derivative: 0");
  EXPECT_TRUE(has_unknown_unit(bare.filters[0].filter));
  EXPECT_FALSE(has_unknown_unit(position.filters[0].filter));
  EXPECT_EQ(derivative_unit("rad", stated.filters[0].filter), "N m");
  EXPECT_EQ(derivative_unit("rad", position.filters[0].filter), "rad");
  EXPECT_EQ(filter_warnings(bare).size(), 1u);
  EXPECT_TRUE(filter_warnings(stated).empty());
  // By hand: (2200 + 2000) times half a count of 2 pi/100000.
  const double worst = analyze(stated).workspace.derivatives[0][0].worst_case.max;
  EXPECT_NEAR(worst, 4200 * std::numbers::pi / 100000, 1e-9);
  EXPECT_NE(write(analyze(bare), "table").find("0.132"), std::string::npos) << write(analyze(bare), "table");
  EXPECT_NE(write(analyze(stated), "table").find("mN m"), std::string::npos);
  EXPECT_THROW(servo(", unit: N mm/rad"), Error) << "a coefficient is in SI units";
  EXPECT_THROW(servo(", unit: furlong"), Error);
}

TEST(Simulation, AMotionThatEndsBeforeItsFiltersHaveSettledIsWarnedOf) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  const auto warned = [&](double duration) {
    spec.motion->duration = duration;
    const std::vector<std::string> all = simulation_report(spec, {}).warnings;
    return std::any_of(all.begin(), all.end(),
                       [](const std::string& w) { return w.find("transients") != std::string::npos; });
  };
  EXPECT_TRUE(warned(0.001));
  EXPECT_TRUE(warned(0.05));
  EXPECT_FALSE(warned(0.2));
}

// An offset along z of a robot that moves in x and y: its z has a constant error, and no figure of it is
// rounding.
TEST(Simulation, FiguresThatAreTheRoundingOfAZeroAreZero) {
  const Spec spec = parse_spec(
      "qerr: 1\nrobot: {joint: {name: j, type: revolute, radius: 100 mm}}\nencoders: {j: {counts_per_rev: "
      "4096}}\n"
      "filters: {v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: butterworth, order: 2, cutoff: 50 "
      "Hz}}}\n"
      "motion: {sample_rate: 1 kHz, duration: 3, joints: {j: {sines: [{amplitude: 1.2, frequency: 1}]}}}\n"
      "effects: [{type: geometry, joint: j, axis: z, length: 1 mm}]\n",
      "one.yaml");
  const SimulationReport report = simulation_report(spec, {});
  const SimulatedSignal& z = report.simulation.results[0][2];
  EXPECT_EQ(z.sigma_simulated, 0);
  EXPECT_NEAR(z.mean_simulated, -1e-3, 1e-12);
  for (const auto& row : report.simulation.results)
    for (const SimulatedSignal& s : row)
      for (const double figure : {s.sigma_simulated, s.mean_simulated, s.peak_simulated})
        EXPECT_TRUE(figure == 0 || std::abs(figure) > 1e-13 * row[0].peak_simulated) << figure;
}

TEST(ControlLaw, WithoutAUnitIsShownWithoutOneInEveryTable) {
  const auto moving = [](const std::string& unit) {
    return servo(unit +
                 "}}\nmotion: {sample_rate: 1 kHz, duration: 200 ms, joints: {j: {velocity: 0.3 rad/s}");
  };
  const auto rows_with_a_unit = [](const Spec& spec) {
    SimulationOptions options;
    options.tracking = true;
    std::istringstream lines(write(simulation_report(spec, options), "table") +
                             write(analyze(spec, {}, {.gap = 0.01, .all = true}), "table"));
    int found = 0;
    for (std::string line; std::getline(lines, line);)
      found +=
          line.starts_with("  torque") && std::regex_search(line, std::regex(" [pnum]?(rad|m|N m)( |$)"));
    return found;
  };
  EXPECT_EQ(rows_with_a_unit(moving("")), 0);
  EXPECT_GT(rows_with_a_unit(moving(", unit: N m/rad")), 2);
}

TEST(Threshold, IsRefusedWhereNothingMovesTheTip) {
  const auto row = [](const std::string& robot) { return threshold_row(servo(", derivative: 1", robot), 1); };
  EXPECT_THROW(row(""), Error);
  // The arm's components along x and y reach the radius at few of 10 configurations.
  EXPECT_NEAR(row(", radius: 80 mm").resolution, 0.08 * 2 * std::numbers::pi / 100000, 1e-2 * 5e-6);
  EXPECT_EQ(row(", radius: 80 mm").filter, "torque") << "whose sample rate it is";
}

TEST(Analysis, UsesIpqnOnlyForAMotionOfTooManySamples) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  spec.filters.resize(1);
  spec.motion->duration = 1e9;
  const Analysis a = analyze(spec);
  EXPECT_FALSE(a.workspace.derivatives[0][0].sigma_in_motion);
  EXPECT_TRUE(std::any_of(a.warnings.begin(), a.warnings.end(), [](const std::string& w) {
    return w.find("only IPQN is given") != std::string::npos;
  }));
}

TEST(Analysis, WarnsOfPitchAtTheGimbalLockOnly) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml");
  spec.model.coordinates = {Coordinate::pitch};
  spec.filters.clear();
  Configurations& c = spec.configurations;
  c.method = SamplingMethod::list;
  c.points = {Eigen::VectorXd::LinSpaced(7, -1, 1)};
  c.count = 1;
  Eigen::Isometry3d& tip = spec.model.chain.tip_offset;
  const Eigen::Matrix3d wrist =
      tip.linear() * forward_kinematics(spec.model.chain, c.points[0]).linear().transpose();
  for (const double off : {0.0, 1e-11}) {
    tip.linear() =
        wrist * Eigen::AngleAxisd(std::numbers::pi / 2 - off, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Analysis a = analyze(spec);
    const bool warned = std::any_of(a.warnings.begin(), a.warnings.end(), [](const std::string& w) {
      return w.find("has no rate") != std::string::npos;
    });
    EXPECT_EQ(std::isinf(a.workspace.coordinates[0].worst_case.max), off == 0);
    EXPECT_EQ(warned, off == 0) << a.workspace.smallest_cosine_of_pitch;
  }
}

/// By hand: each joint errs by Delta/2 + A at most, and by sqrt(Delta^2/12 + A^2/2) on average.
TEST(Analysis, AddsTheAccuracyOfAnEncoderLikeASineOfThatAmplitudeAndUnknownPhase) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml");
  spec.motion.reset();
  spec.configurations.count = 200;
  const double delta = 2 * std::numbers::pi / 131072, bound = 20 * std::numbers::pi / 648000;
  for (Encoder& e : spec.model.transmission.encoders) e.resolution = delta, e.accuracy = 0;
  const Analysis without = analyze(spec);
  for (Encoder& e : spec.model.transmission.encoders) e.accuracy = bound;
  const Analysis with = analyze(spec);
  const double worst = 1 + bound / (0.5 * delta), sigma = std::sqrt(1 + 6 * std::pow(bound / delta, 2));
  for (std::size_t c = 0; c < with.workspace.coordinates.size(); ++c) {
    const auto &has = with.workspace.coordinates[c], &had = without.workspace.coordinates[c];
    EXPECT_NEAR(has.worst_case.max / had.worst_case.max, worst, 1e-12);
    EXPECT_NEAR(has.worst_case.p50 / had.worst_case.p50, worst, 1e-12);
    EXPECT_NEAR(has.sigma.max / had.sigma.max, sigma, 1e-12);
    EXPECT_GE(has.worst_case_rigorous.max, has.worst_case.max);
    for (std::size_t f = 0; f < spec.filters.size(); ++f) {
      const auto &behind = with.workspace.derivatives[f][c], &before = without.workspace.derivatives[f][c];
      EXPECT_NEAR(behind.worst_case.max / before.worst_case.max, worst, 1e-12);
      ASSERT_TRUE(behind.sigma && behind.sigma_quantization);
      EXPECT_GE(behind.sigma->max, before.sigma->max);
      EXPECT_NEAR(behind.sigma_quantization->max, before.sigma->max, 1e-12 * before.sigma->max);
    }
  }
  const auto warned = [](const Analysis& a, const std::string& words) {
    return std::any_of(a.warnings.begin(), a.warnings.end(),
                       [&](const std::string& w) { return w.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(warned(with, "`accuracy` as a sine of one period a revolution"));
  // Without a motion and a limit of speed its spectrum is not known.
  for (IndependentJoint& joint : spec.model.chain.independent) joint.velocity_limit.reset();
  const Analysis without_speed = analyze(spec);
  for (const auto& of_filter : without_speed.workspace.derivatives)
    for (const DerivativeStatistics& d : of_filter) EXPECT_TRUE(!d.sigma && d.sigma_quantization);
  EXPECT_TRUE(warned(without_speed, "sigma behind a filter is not given"));
}

}  // namespace
}  // namespace qerr
