#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/bound/velocity_estimators.hpp"
#include "qerr/core/error.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/simulation_report.hpp"
#include "simulate/estimators/estimator.hpp"

namespace qerr {
namespace {

std::string turntable(const std::string& estimators, const std::string& motion,
                      const std::string& more = "") {
  return "qerr: 1\nrobot: {joint: {name: j, type: revolute, limits: [-1000, 1000]}}\ncoordinates: [rz]\n"
         "encoders: {j: {counts_per_rev: 4096}}\nestimators: {" +
         estimators + "}\nmotion: {sample_rate: 1 kHz, duration: 4 s, settling: 1 s, joints: {j: {" + motion +
         "}}}\n" + more;
}

std::vector<EstimatedVelocity> compared(const std::string& spec) {
  return estimator_comparison(parse_spec(spec, "a.yaml"), {});
}

std::string comparison_refusal(const std::string& spec) {
  try {
    compared(spec);
  } catch (const Error& e) {
    return e.faults().front().rule + "; " + e.faults().front().remedy;
  }
  return "";
}

constexpr double delta = 2 * std::numbers::pi / 4096;

TEST(EdgeFinder, FindsEachEdgeOfASineAndOfItsReversals) {
  const double amplitude = 7.3 * delta;
  const EncoderPath path{[=](double t) { return amplitude * std::sin(t); },
                         [=](double t) { return amplitude * std::cos(t); }, 0.01};
  EdgeFinder finder({.resolution = delta}, {}, path, 0);
  std::vector<Edge> all;
  for (const double t : {0.1, 0.7, 1.5, 1.6, 3.0, 4.7, 4.8, 6.2, 2 * std::numbers::pi})
    for (const Edge& e : finder.until(t)) all.push_back(e);
  ASSERT_EQ(all.size(), 28u);  // 7 thresholds on either side, each crossed twice
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double counts = path.position(all[i].time) / delta;
    EXPECT_NEAR(std::abs(counts - std::floor(counts)), 0.5, 1e-8);
    EXPECT_EQ(all[i].direction, i < 7 || i >= 21 ? 1 : -1);
  }
}

TEST(EdgeTiming, ErrsAtConstantSpeedByItsBoundAtMost) {
  const std::vector<EstimatedVelocity> all =
      compared(turntable("e: {kind: edge_timing, clock: 100 kHz}", "velocity: 1.234"));
  const EstimatorError bound = inverse_time_error(delta, 1e5, 1.234);
  EXPECT_LE(all[0].worst, bound.constant * (1 + 1e-6));
  EXPECT_GE(all[0].worst, 0.9 * bound.constant);
  EXPECT_NEAR(*all[0].worst_case, bound.varying, 1e-12);
  EXPECT_FALSE(all[0].delay);  // the speed never changes
}

TEST(EdgeTiming, HasNoBoundWhereTheSpeedChangesOrTwoEdgesAreStillToCome) {
  for (const char* motion : {"sines: [{amplitude: 1, frequency: 0.5 Hz}]", "velocity: 0.0001"}) {
    const std::vector<EstimatedVelocity> all =
        compared(turntable("e: {kind: edge_timing, clock: 100 kHz}", motion));
    EXPECT_FALSE(all[0].worst_case) << motion;
    EXPECT_GT(all[0].worst, 0) << motion;
  }
}

TEST(EdgeTiming, OverALineIsNotChangedByUnequalStates) {
  const std::vector<EstimatedVelocity> all =
      compared(turntable("edges: {kind: edge_timing, clock: 100 MHz}, lines: {kind: edge_timing, clock: 100 "
                         "MHz, edges: line}",
                         "velocity: 0.5", "effects: [{type: state_width, joint: j, phase: 0.3}]"));
  EXPECT_EQ(all[0].estimator, "lines");
  EXPECT_LT(all[0].worst, 1e-5);
  // Edges of the second channel are late by 4 * 0.3/(2 pi) counts: states are 0.19 wider and narrower.
  EXPECT_NEAR(all[1].worst, 0.5 * (1 / (1 - 4 * 0.3 / (2 * std::numbers::pi)) - 1), 1e-3);
}

TEST(CountAndTime, IsExactUpToTheClockAtConstantSpeed) {
  const std::vector<EstimatedVelocity> all =
      compared(turntable("m: {kind: count_and_time, window: 20 ms, clock: 10 MHz}", "velocity: 0.777"));
  // Over 20 ms less a count, two stamps of a tick each.
  EXPECT_LT(all[0].worst, 0.777 * 1e-7 / (0.02 - delta / 0.777));
}

TEST(HeldDifference, HoldsItsValueUntilTheCountChanges) {
  const VelocityEstimate held =
      estimator_kind("held_difference").make({"", "", {{"time_constant", 0.0}}, {}, {}}, {delta, 1e-3, 4});
  EXPECT_EQ(held({0.000, 0, {}}), 0);
  EXPECT_EQ(held({0.001, 0, {}}), 0);
  EXPECT_NEAR(held({0.002, 1, {}}), 1 / 0.002, 1e-9);
  EXPECT_NEAR(held({0.003, 1, {}}), 1 / 0.002, 1e-9);
  EXPECT_NEAR(held({0.006, 3, {}}), 2 / 0.004, 1e-9);
}

TEST(AdaptiveWindow, StopsAtTheFirstWindowThatDoesNotFit) {
  const auto at = [](double band) {
    const VelocityEstimate window =
        estimator_kind("adaptive_window")
            .make({"", "", {{"longest", 8.0}, {"band", band}}, {{"fit", "end"}}, {}}, {delta, 1, 4});
    double v = 0, t = 0;
    for (const double count : {0.0, 0.0, 4.0, 5.0, 6.0, 7.0}) v = window({t++, count, {}});
    return v;
  };
  // Four samples back the line misses by 2.25 counts, five back by 1.4 only.
  EXPECT_DOUBLE_EQ(at(0.5), 1);
  EXPECT_DOUBLE_EQ(at(1.5), 1);
  EXPECT_DOUBLE_EQ(at(2.5), 1.4);
}

TEST(AdaptiveKalman, AndTheDifferentiatorFollowASlowSine) {
  const std::vector<EstimatedVelocity> all = compared(
      turntable("k: {kind: adaptive_kalman}, r: {kind: robust_differentiator, acceleration: 20 }, h: {kind: "
                "held_difference, time_constant: 0}",
                "sines: [{amplitude: 1, frequency: 0.5 Hz}]"));
  ASSERT_EQ(all.size(), 3u);
  const double speed = std::numbers::pi / std::numbers::sqrt2;
  for (const EstimatedVelocity& e : all)
    if (e.estimator != "h") {
      EXPECT_LT(e.rms, 0.1 * speed) << e.estimator;
      EXPECT_EQ(e.rms < all.back().rms, true) << e.estimator;
    }
}

TEST(VelocityComparison, FindsTheDelayOfAFilter) {
  const std::string filter =
      "filters: {v: {derivative: 1, sample_rate: 500, lowpass: {family: first_order, order: 2, cutoff: "
      "20}}}\n";
  const std::vector<EstimatedVelocity> all =
      compared(turntable("", "sines: [{amplitude: 2, frequency: 0.5}]", filter));
  const Spec spec = parse_spec(turntable("", "velocity: 1", filter), "a.yaml");
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind, "filter");
  EXPECT_NEAR(*all[0].delay, group_delay(spec.filters[0].filter), 2e-5);
  EXPECT_NEAR(*all[0].worst_case, spec.filters[0].norms.l1.upper * delta / 2, 1e-12);
  EXPECT_LT(all[0].noise, all[0].rms);
  EXPECT_NEAR(std::hypot(all[0].noise, all[0].tracking), all[0].rms, 0.01 * all[0].rms);
}

TEST(Estimators, ThatTimeEdgesAreWarnedOfEffectsThatTheyDoNotSee) {
  const auto warnings = [](const std::string& estimator, const std::string& effect) {
    return estimator_warnings(parse_spec(
        turntable("e: {" + estimator + "}", "velocity: 1", "effects: [" + effect + "]\n"), "a.yaml"));
  };
  const std::string timed = "kind: edge_timing, clock: 100 kHz",
                    noise = "{type: noise, joint: j, sigma: 1 mrad}",
                    disc = "{type: eccentricity, joint: j, amplitude: 1 mrad}";
  ASSERT_EQ(warnings(timed, noise).size(), 1u);
  EXPECT_NE(warnings(timed, noise)[0].find("'e'"), std::string::npos);
  EXPECT_NE(warnings(timed, noise)[0].find("'noise'"), std::string::npos);
  EXPECT_TRUE(warnings(timed, disc).empty());
  EXPECT_TRUE(warnings("kind: held_difference", noise).empty());
}

TEST(Estimators, ThatDoNotExistAreRefusedWithWhatWouldBeRight) {
  EXPECT_NE(
      comparison_refusal(turntable("e: {kind: edge_timin, clock: 1 MHz}", "velocity: 1")).find("edge_timing"),
      std::string::npos);
  EXPECT_NE(comparison_refusal(turntable("e: {kind: tracking_loop, bandwidth: 100}", "velocity: 1"))
                .find("filters"),
            std::string::npos);
  EXPECT_NE(comparison_refusal(turntable("e: {kind: edge_timing}", "velocity: 1")).find("clock"),
            std::string::npos);
  EXPECT_NE(comparison_refusal(turntable("e: {kind: edge_timing, clock: 1 MHz, clok: 2}", "velocity: 1"))
                .find("unknown"),
            std::string::npos);
  EXPECT_NE(comparison_refusal(turntable("", "velocity: 1")).find("no velocity estimator"),
            std::string::npos);
  EXPECT_NE(comparison_refusal(turntable("e: {kind: edge_timing, clock: 1 MHz}", "velocity: 1",
                                         "effects: [{type: eccentricity, joint: j, amplitude: 1.5 rad}]"))
                .find("coincide"),
            std::string::npos);
}

}  // namespace
}  // namespace qerr
