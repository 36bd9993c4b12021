
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "filter/run/cascade.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/simulation_report.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/tables.hpp"

namespace qerr {
namespace {

std::string text(const std::string& encoder, const std::string& more) {
  return "qerr: 1\nrobot: {joint: {name: j, type: revolute, limits: [-2, 2], velocity: 3}}\n"
         "coordinates: [rz]\nencoders: {j: " +
         encoder +
         "}\nconfigurations: {count: 64}\n"
         "filters:\n  v: {derivative: 1, sample_rate: 500 Hz, lowpass: {family: first_order, order: 2, "
         "cutoff: 30 Hz}}\n"
         "  p: {derivative: 0, sample_rate: 500 Hz, lowpass: {family: butterworth, order: 3, cutoff: 8 "
         "Hz}}\n" +
         more;
}

const std::string sines =
    "motion: {sample_rate: 500 Hz, duration: 8 s, joints: {j: {center: 0.2, sines: "
    "[{amplitude: 0.9, frequency: 0.4 Hz}, {amplitude: 0.2, frequency: 1.3 Hz, phase: 1}]}}}\n";

double sigma_behind(const Analysis& a, std::size_t filter) {
  return a.workspace.derivatives[filter][0].sigma->max;
}

TEST(SlowErrors, AlongAMotionAreTheMeanOfEccentricitiesOfAllPhases) {
  // Three phases at 120 degrees average like all of them: the variance is a sine of twice the phase.
  for (const double ratio : {1.0, 12.0}) {
    const std::string gear = ", gear_ratio: " + std::to_string(ratio);
    const Analysis bound =
        analyze(parse_spec(text("{bits: 23, accuracy: 5 mrad" + gear + "}", sines), "a.yaml"));
    for (const std::size_t f : {0u, 1u}) {
      double mean = 0;
      for (const char* phase : {"0 deg", "120 deg", "240 deg"}) {
        const Analysis one = analyze(parse_spec(
            text("{bits: 23" + gear + "}", sines + "effects: [{type: eccentricity, joint: j, amplitude: " +
                                               std::to_string(0.005 / ratio) + ", phase: " + phase + "}]\n"),
            "a.yaml"));
        const double mean_of_signal = one.spec.model.along_motion->filtered[f].mean[0];
        mean += (std::pow(sigma_behind(one, f), 2) + mean_of_signal * mean_of_signal) / 3;
      }
      EXPECT_NEAR(sigma_behind(bound, f), std::sqrt(mean), 0.01 * std::sqrt(mean))
          << ratio << " filter " << f;
    }
  }
}

TEST(SlowErrors, OfAGearHaveTwoPeriodsARevolution) {
  const Spec of_gear = parse_spec(text("{bits: 23, gear_ratio: 10, gear_accuracy: 1 mrad}", sines), "a.yaml");
  const Spec of_disc = parse_spec(text("{bits: 23, gear_ratio: 20, accuracy: 20 mrad}", sines), "a.yaml");
  EXPECT_DOUBLE_EQ(of_gear.model.transmission.encoders[0].gear_accuracy, 1e-3);
  EXPECT_DOUBLE_EQ(of_disc.model.transmission.encoders[0].accuracy, 1e-3);
  const SlowErrorRatios gear = slow_error_ratios(of_gear), disc = slow_error_ratios(of_disc);
  for (const std::size_t f : {0u, 1u})
    EXPECT_DOUBLE_EQ(gear.gear_accuracy[0].filters[f], disc.accuracy[0].filters[f]);
}

TEST(SlowErrors, StepsOfPlayAreThoseOfASquareWaveThroughTheFilter) {
  const Spec spec = parse_spec(text("{bits: 23}", ""), "a.yaml");
  const double energy = step_energies(designed_filters(spec))[0];
  constexpr int half_period = 4000, periods = 4;
  Cascade<double> run(spec.filters[0].filter);
  double sum = 0;
  for (int k = 0; k < 2 * half_period * periods; ++k) {
    const double y = run.step(k / half_period % 2 == 0 ? 0 : 1);
    if (k >= half_period) sum += y * y;
  }
  const int counted = 2 * half_period * periods - half_period;
  const double reversals = 500.0 / half_period;  // a second
  EXPECT_NEAR(sum / counted, energy * reversals, 1e-9 * sum / counted);
  EXPECT_TRUE(std::isnan(step_energies(designed_filters(spec))[1])) << "a position filter keeps the step";
}

TEST(SlowErrors, BehindAFilterStandBesideSigmaOfQuantizationAlone) {
  const Analysis plain = analyze(parse_spec(text("{bits: 12}", ""), "a.yaml"));
  const Analysis slow = analyze(parse_spec(text("{bits: 12, accuracy: 0.2 deg}", ""), "a.yaml"));
  for (const std::size_t f : {0u, 1u}) {
    EXPECT_FALSE(plain.workspace.derivatives[f][0].sigma_quantization);
    ASSERT_TRUE(slow.workspace.derivatives[f][0].sigma_quantization);
    EXPECT_NEAR(slow.workspace.derivatives[f][0].sigma_quantization->max, sigma_behind(plain, f),
                1e-12 * sigma_behind(plain, f));
    const double added =
        slow_error_ratios(slow.spec).accuracy[0].filters[f] * 0.2 * std::numbers::pi / 180 / std::sqrt(2.0);
    EXPECT_NEAR(sigma_behind(slow, f), std::hypot(sigma_behind(plain, f), added), 1e-12);
  }
}

TEST(CountRates, AreSpeedTimesCountsThroughTheCoupling) {
  std::mt19937_64 draw(5);
  std::uniform_real_distribution<> any(0.2, 4);
  for (int i = 0; i < 50; ++i) {
    const double counts = std::floor(1000 * any(draw)), gear = -any(draw), speed = any(draw);
    const Spec spec =
        parse_spec("qerr: 1\nrobot: {joint: {name: j, type: revolute, limits: [-2, 2], velocity: " +
                       std::to_string(speed) + "}}\ncoordinates: [rz]\nencoders: {j: {counts_per_rev: " +
                       std::to_string(counts) + ", gear_ratio: " + std::to_string(gear) + "}}\n",
                   "a.yaml");
    const double shaft = std::stod(std::to_string(-gear)) * std::stod(std::to_string(speed));
    EXPECT_NEAR(count_rate(spec, 0, *encoder_speeds(spec)[0]), shaft * counts / (2 * std::numbers::pi),
                1e-9 * counts);
  }
}

TEST(CountRates, AndSpeedsOfNarrowCountersAreInEveryFormat) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.1, 1);
  for (int i = 0; i < 20; ++i) {
    const double ratio = 200 * unit(random), limit = 3 * unit(random);
    const int lines = 100 + static_cast<int>(2000 * unit(random)), bits = 8 + i % 12;
    const Spec spec = parse_spec(
        "qerr: 1\nrobot: {joint: {name: table, type: revolute, velocity: " + std::to_string(limit) +
            "}}\nencoders: {table: {lines_per_rev: " + std::to_string(lines) +
            ", gear_ratio: " + std::to_string(ratio) + ", counter_bits: " + std::to_string(bits) +
            "}}\nfilters: {v: {derivative: 1, sample_rate: 1 kHz}, w: {derivative: 1, sample_rate: 500}}\n",
        "a.yaml");
    const double edges = 4.0 * lines * std::stod(std::to_string(ratio)) / (2 * std::numbers::pi);
    const double speed = std::stod(std::to_string(limit));
    // The difference of two readings of a counter of n bits is read as one of -2^(n-1) .. 2^(n-1) - 1.
    const double largest = 500 * std::pow(2.0, bits - 1) / edges;
    EXPECT_NEAR(count_rate(spec, 0, speed), edges * speed, 1e-9 * edges);
    EXPECT_NEAR(*largest_speed(spec, 0), largest, 1e-9 * largest);
    const Analysis a = analyze(spec);
    EXPECT_EQ(!count_rate_warnings(spec).empty(), speed > largest);
    EXPECT_NE(write(a, "csv").find("encoder,,table,1/s,count_rate,max,"), std::string::npos);
    EXPECT_NE(write(a, "table").find("Counters"), std::string::npos);
  }
}

TEST(CountRates, TooHighAWarningNamesTheLowestLimit) {
  const auto warnings = [](const std::string& encoder) {
    return count_rate_warnings(parse_spec(text(encoder, ""), "a.yaml"));
  };
  // 4096 counts at 3 rad/s: 1956 a second, 489 lines a second, 3.9 counts a sample of 500 Hz.
  EXPECT_TRUE(warnings("{counts_per_rev: 4096, max_count_rate: 1957 Hz}").empty());
  EXPECT_EQ(warnings("{counts_per_rev: 4096, max_count_rate: 1955 Hz}").size(), 1u);
  EXPECT_TRUE(warnings("{lines_per_rev: 1024, max_frequency: 489 Hz}").empty());
  EXPECT_EQ(warnings("{lines_per_rev: 1024, max_frequency: 488 Hz}").size(), 1u);
  EXPECT_TRUE(warnings("{counts_per_rev: 4096, counter_bits: 3}").empty());
  EXPECT_EQ(warnings("{counts_per_rev: 4097, counter_bits: 2}").size(), 1u);
  EXPECT_THROW(warnings("{counts_per_rev: 4096, max_frequency: 1 kHz, max_count_rate: 4 kHz}"), Error);
}

TEST(CountRates, TooHighAlongAMotionAreWarnedOfBySimulate) {
  const auto warned = [](const std::string& counter) {
    const Spec spec = parse_spec(
        "qerr: 1\nrobot: {joint: {name: j, type: revolute}}\nencoders: {j: {counts_per_rev: 4096, " +
            counter +
            "}}\nfilters: {v: {derivative: 1, sample_rate: 500 Hz}}\n"
            "motion: {sample_rate: 1 kHz, duration: 1, joints: {j: {velocity: 3 rad/s}}}\n",
        "a.yaml");
    const std::vector<std::string> all = simulation_report(spec, {}).warnings;
    return std::count_if(all.begin(), all.end(), [](const std::string& w) {
      return w.find("cannot count fast enough") != std::string::npos;
    });
  };
  EXPECT_EQ(warned("max_count_rate: 1957 Hz"), 0);
  EXPECT_EQ(warned("max_count_rate: 1955 Hz"), 1);
  EXPECT_EQ(warned("max_frequency: 488 Hz"), 1);
  EXPECT_EQ(warned("counter_bits: 2"), 1);
}

TEST(GearAccuracy, AnAccuracyBehindAGearThatCouldBeTheGearsIsAskedAbout) {
  const auto asked = [](const std::string& encoder) {
    for (const std::string& w : parse_spec(text(encoder, ""), "a.yaml").warnings)
      if (w.find("gear_accuracy") != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(asked("{bits: 12, gear_ratio: 100, accuracy: 1 arcmin}"));
  EXPECT_FALSE(asked("{bits: 12, gear_ratio: 100, accuracy: 20 arcsec}")) << "better than gears are";
  EXPECT_FALSE(asked("{bits: 12, accuracy: 1 arcmin}")) << "no gear";
  EXPECT_FALSE(asked("{bits: 12, gear_ratio: 100, accuracy: 20 arcmin, gear_accuracy: 1 arcmin}"));
  EXPECT_THROW(asked("{resolution: 1 mrad, gear_accuracy: 1 arcmin}"), Error);
}

}  // namespace
}  // namespace qerr
