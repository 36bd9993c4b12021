#include "qerr/diagnose/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/write.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {
namespace {

using std::numbers::pi;
constexpr double infinite = std::numeric_limits<double>::infinity();

/// One revolute joint with an encoder of `counts` per revolution and a gear ratio of `ratio`.
OperationalModel stage(double counts, double ratio) {
  OperationalModel m;
  ChainJoint joint;
  joint.name = "turn";
  m.chain.joints.push_back(joint);
  m.chain.independent.push_back({"turn", JointType::revolute, Limits{-3, 3}, true, 4.0, {}});
  m.transmission.coupling = Eigen::MatrixXd::Identity(1, 1);
  m.transmission.encoders.push_back({2 * pi / counts / ratio, Rounding::nearest, true, ratio});
  m.coordinates = {Coordinate::x};
  return m;
}

Motion motion(JointMotion joint, double duration, double rate = 500) {
  return {rate, duration, {}, {joint}, {}};
}

JointMotion to_and_fro(double amplitude, double frequency) {
  return {0.1, 0, {{amplitude, frequency, 0.3}, {0.3 * amplitude, 2.7 * frequency, 1}}, {}};
}

/// Without the minimum magnitude of an identification: the statistical threshold only.
PlanOptions statistics() {
  PlanOptions o;
  o.least_amplitude = 0;
  o.improve = false;
  return o;
}

const PlannedEffect& find(const PlannedJoint& joint, const std::string& type, const std::string& shaft = "") {
  for (const PlannedEffect& p : joint.effects)
    if (p.effect.type == type && (shaft.empty() || p.effect.choices.at("shaft") == shaft)) return p;
  throw std::out_of_range(type);
}

bool twins(const PlannedEffect& p, const std::string& type) {
  return std::any_of(p.correlated.begin(), p.correlated.end(),
                     [&](const CorrelatedEffect& r) { return r.effect.type == type && r.inseparable(); });
}

TEST(Plan, CannotDistinguishOffsetBacklashAndLatencyInOneDirectionAtOneSpeed) {
  const Plan p = plan(stage(4000, 50), {}, motion({-1, 0.5, {}, {}}, 4), statistics());
  const PlannedJoint& turn = p.joints[0];
  for (const char* one : {"offset", "backlash", "latency"})
    for (const char* other : {"offset", "backlash", "latency"})
      EXPECT_TRUE(one == std::string(other) || twins(find(turn, one), other)) << one << ' ' << other;
  EXPECT_EQ(find(turn, "backlash").identifiable, infinite);
  EXPECT_TRUE(twins(find(turn, "noise"), "timing_jitter"));
}

TEST(Plan, DistinguishesThemByReversalsAtSeveralSpeeds) {
  const PlannedJoint turn = plan(stage(4000, 50), {}, motion(to_and_fro(1, 0.4), 8), statistics()).joints[0];
  for (const char* one : {"offset", "backlash", "latency", "timing_jitter"}) {
    EXPECT_FALSE(find(turn, one).has_inseparable()) << one;
    EXPECT_LT(find(turn, one).identifiable, infinite) << one;
  }
}

TEST(Plan, CannotDistinguishLatencyAndBacklashAlongATriangleAtOneSpeed) {
  JointMotion triangle{-1, 0, {}, {{1, 1.0, 1000, 0, 0}, {-1, 1.0, 1000, 0, 0}}};
  const PlannedJoint turn = plan(stage(4000, 50), {}, motion(triangle, 9), statistics()).joints[0];
  EXPECT_TRUE(twins(find(turn, "backlash"), "latency"));
  EXPECT_FALSE(twins(find(turn, "backlash"), "offset"));
}

TEST(Plan, CannotDistinguishEccentricityFromScaleOrOffsetWithinOneRevolution) {
  const auto eccentricity = [&](double amplitude) {
    const Plan p = plan(stage(40000, 1), {}, motion(to_and_fro(amplitude, 0.4), 8), statistics());
    return find(p.joints[0], "eccentricity", "encoder");
  };
  EXPECT_TRUE(twins(eccentricity(0.6), "scale"));
  EXPECT_TRUE(twins(eccentricity(0.6), "offset"));
  EXPECT_FALSE(twins(eccentricity(8), "scale"));
  EXPECT_FALSE(twins(eccentricity(8), "offset"));
}

TEST(Plan, CannotDistinguishOrdersOfShaftsWithAnIntegerRatio) {
  const PlannedJoint turn = plan(stage(4000, 3), {}, motion(to_and_fro(2, 0.4), 8), statistics()).joints[0];
  const PlannedEffect& disc = find(turn, "eccentricity", "encoder");
  const auto third =
      std::find_if(disc.correlated.begin(), disc.correlated.end(), [](const CorrelatedEffect& r) {
        return r.effect.number("order") == 3 && r.effect.choices.at("shaft") == "joint";
      });
  ASSERT_NE(third, disc.correlated.end());
  EXPECT_TRUE(third->inseparable());
  EXPECT_NEAR(third->correlation, 1, 1e-9);
}

TEST(Plan, HasThresholdsInverseToTheRootOfTheNumberOfReadings) {
  // Four times the readings of the same motion.
  const auto at = [&](double rate) {
    return plan(stage(40000, 50), {}, motion(to_and_fro(1, 0.4), 8, rate), statistics()).joints[0];
  };
  const PlannedJoint few = at(250), many = at(1000);
  EXPECT_NEAR(many.readings / few.readings, 4, 0.02);
  for (const char* type : {"offset", "backlash", "latency", "eccentricity"}) {
    // The threshold grows with log n only.
    EXPECT_NEAR(find(few, type).detectable / find(many, type).detectable, 2, 0.15) << type;
  }
}

TEST(Plan, IncludesAllReadingsOfLongMotions) {
  const Motion m = motion(to_and_fro(1, 0.1), 40, 1000);
  PlanOptions all = statistics(), part = statistics();
  all.most_rows = 100000;
  part.most_rows = 5000;
  const PlannedJoint one = plan(stage(4000, 50), {}, m, all).joints[0],
                     other = plan(stage(4000, 50), {}, m, part).joints[0];
  EXPECT_NEAR(other.readings, one.readings, 0.02 * one.readings);
  for (const char* type : {"offset", "scale", "latency", "eccentricity"})
    EXPECT_NEAR(find(other, type).detectable, find(one, type).detectable, 0.03 * find(one, type).detectable)
        << type;
}

TEST(Plan, HasTheFisherInformationOfAnOffsetFromReadingsAtEdges) {
  // With little noise of the reference only the edges are informative, each with the information of a probit
  // of its noise s: I = 1/(pi s) int phi^2/(Phi (1 - Phi)) dz / s = 1.8063/s. Independent: the integral by
  // hand.
  const auto offset = [&](double noise) {
    PlanOptions o = statistics();
    o.reference_noise = noise;
    return find(plan(stage(4000, 50), {}, motion(to_and_fro(1, 0.4), 8), o).joints[0], "offset")
        .detectable_counts();
  };
  double integral = 0;
  for (double z = -8; z < 8; z += 1e-3) {
    const double phi = std::exp(-0.5 * z * z) / std::sqrt(2 * pi), below = 0.5 * std::erfc(-z / std::sqrt(2));
    integral += 1e-3 * phi * phi / (below * (1 - below));
  }
  // Edges with a width of 1/20 count do not overlap; twice as wide, half the information.
  EXPECT_NEAR(offset(0.04) / offset(0.02), std::sqrt(2), 0.02);
  // At several counts quantization adds its own variance of 1/12, and nothing else.
  const double wide = 3;
  EXPECT_NEAR(offset(wide) / offset(0.02), std::sqrt(integral / 0.02 * (wide * wide + 1.0 / 12)),
              0.02 * offset(wide) / offset(0.02));
}

TEST(Plan, HasNoEffectsForAJointAtRest) {
  const Plan p = plan(stage(4000, 50), {}, motion({0.3, 0, {}, {}}, 4));
  EXPECT_FALSE(p.joints[0].moves);
  EXPECT_TRUE(p.joints[0].effects.empty());
  ASSERT_TRUE(p.better);
  EXPECT_TRUE(p.joints_better[0].moves);
}

TEST(Plan, ProposesABetterMotionWithinTheLimits) {
  const Plan p = plan(stage(4000, 50), {}, motion({-1, 0.5, {}, {}}, 4));
  ASSERT_TRUE(p.better);
  EXPECT_EQ(p.changed, std::vector<std::size_t>{0});
  EXPECT_EQ(p.better->duration, 4);
  const Eigen::MatrixX2d range = extent(*p.better);
  EXPECT_GE(range(0, 0), -3);
  EXPECT_LE(range(0, 1), 3);
  for (const char* type : {"offset", "backlash", "latency"}) {
    EXPECT_EQ(find(p.joints[0], type).identifiable, infinite) << type;
    EXPECT_LT(find(p.joints_better[0], type).identifiable, infinite) << type;
  }
  const MotionPath path(*p.better);
  for (double t = 0; t < 4; t += 0.01) EXPECT_LE(std::abs(path.at(0, t).velocity), 4) << t;
}

TEST(Plan, KeepsAMotionThatItProposedItself) {
  const Plan first = plan(stage(4000, 50), {}, motion({-1, 0.5, {}, {}}, 4));
  ASSERT_TRUE(first.better);
  EXPECT_FALSE(plan(stage(4000, 50), {}, *first.better).better);
}

TEST(Plan, IncludesTheNoiseOfTheSpec) {
  const OperationalModel model = stage(4000, 50);
  const Effect noise{"noise", "turn", {{"sigma", model.transmission.encoders[0].resolution}}, {}};
  const Motion m = motion(to_and_fro(1, 0.4), 8);
  const double quiet = find(plan(model, {}, m, statistics()).joints[0], "offset").detectable,
               loud = find(plan(model, {noise}, m, statistics()).joints[0], "offset").detectable;
  EXPECT_GT(loud, 3 * quiet);
}

TEST(PlanReport, WritesAMotionThatReadsBackUnchanged) {
  const std::string path = std::string(QERR_SOURCE_DIR) + "/configs/diagnosis/spec.yaml";
  const Spec spec = read_spec(path);
  std::string text = spec.text;
  text.erase(text.find("\nmotion:") + 1);
  const Spec again = parse_spec(text + motion_text(*spec.motion, spec.model.chain), path);
  ASSERT_TRUE(again.motion);
  EXPECT_EQ(again.motion->sample_rate, spec.motion->sample_rate);
  const MotionPath was(*spec.motion), is(*again.motion);
  for (double t = 0; t < 8; t += 0.37) EXPECT_EQ(was.position(t), is.position(t)) << t;
}

}  // namespace
}  // namespace qerr
