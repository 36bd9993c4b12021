#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/simulation_report.hpp"
#include "report/simulation/parts.hpp"
#include "simulate/along_motion.hpp"
#include "support/design_filter.hpp"
#include "support/simulate_experiment.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

/// A slider along x: its tip is where its joint is.
Spec tracked_slider(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
  SpecOverrides all{{{"encoders", "{'*': {resolution: 1 nm}}"},
                     {"coordinates", "[x, y, rx]"},
                     {"filters",
                      "{v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: butterworth, order: 2, "
                      "cutoff: 40 Hz}}}"},
                     {"motion",
                      "{sample_rate: 1 kHz, duration: 3 s, settling: 1 s, joints: {slider: {sines: "
                      "[{amplitude: 20 mm, frequency: 6 Hz, phase: 0.4}]}}}"}},
                    {}};
  all.values.insert(all.values.end(), changes.begin(), changes.end());
  return parse_spec("qerr: 1\nrobot: {urdf: configs/paper/slider.urdf}\n", QERR_SOURCE_DIR "/slider.yaml",
                    all);
}

SimulatedSignal simulated(const Spec& spec, std::size_t coordinate = 0) {
  SimulationOptions options;
  options.tracking = true;
  return simulation_report(spec, options).simulation.results[1][coordinate];
}

TEST(TrackingAlongMotion, OfASineIsTheFiltersErrorAtItsFrequency) {
  for (const char* derivative : {"1", "2"}) {
    const Spec spec = tracked_slider({{"filters.v.derivative", derivative}});
    const Filter& filter = spec.filters[0].filter;
    const SimulatedSignal s = simulated(spec);
    const double amplitude =
        0.02 * std::pow(2 * pi * 6, filter.derivative) * fidelity(filter, 6).tracking_error;
    EXPECT_NEAR(s.tracking_rms, amplitude / std::sqrt(2.0), 1e-9 * amplitude);
    EXPECT_NEAR(s.tracking_peak, amplitude, 1e-3 * amplitude) << "the samples miss the peak";
    EXPECT_NEAR(s.total_rms, std::hypot(s.tracking_rms, s.sigma_simulated), 1e-6 * s.total_rms);
  }
}

TEST(TrackingAlongMotion, OfAConstantVelocityIsTheDelayOfThePosition) {
  const Spec spec = tracked_slider(
      {{"filters.v.derivative", "0"}, {"motion.joints", "{slider: {center: 0.5, velocity: 0.1}}"}});
  const double lag = 0.1 * *find_filter_figure("delay")->value(spec.filters[0].filter, spec.filters[0].norms);
  EXPECT_NEAR(simulated(spec).tracking_rms, lag, 1e-9 * lag);
  const Spec velocity = tracked_slider({{"motion.joints", "{slider: {velocity: 0.1}}"}});
  EXPECT_LT(simulated(velocity).tracking_rms, 1e-10) << "a constant velocity has settled";
}

TEST(TrackingAlongMotion, AddsToTheErrorOfALatencyWithItsSign) {
  const Spec late = tracked_slider({{"effects", "[{type: latency, joint: slider, delay: 4 ms}]"}});
  const Filter& filter = late.filters[0].filter;
  const double omega = 2 * pi * 6;
  const Fidelity f = fidelity(filter, 6);
  const std::complex<double> over_ideal = std::polar(1 + f.gain_error, f.phase_error - omega * 4e-3);
  const double amplitude = 0.02 * omega * std::abs(over_ideal - 1.0);
  const SimulatedSignal s = simulated(late);
  EXPECT_NEAR(s.total_rms, amplitude / std::sqrt(2.0), 1e-6 * amplitude);
  EXPECT_GT(s.total_rms, 1.2 * std::hypot(s.tracking_rms, s.sigma_simulated)) << "delays add up";
}

TEST(TrackingAlongMotion, IsKnownForPositionsOnly) {
  EXPECT_TRUE(std::isnan(simulated(tracked_slider(), 2).tracking_rms));
  EXPECT_EQ(simulated(tracked_slider(), 1).tracking_rms, 0) << "y does not move";
  EXPECT_TRUE(std::isnan(simulated(tracked_slider({{"filters.v.derivative", "3"}})).tracking_rms));
}

TEST(TrackingAlongMotion, OfATurningTipHasTheSameLengthInBothFrames) {
  const auto length = [](const char* frame) {
    const Spec spec = read_spec(
        QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml",
        {{{"frame", frame},
          {"coordinates", "[x, y, z]"},
          {"motion",
           "{sample_rate: 1 kHz, duration: 1 s, joints: {a1: {sines: [{amplitude: 0.5, frequency: 2 Hz}]}, "
           "a4: {center: 0.7, sines: [{amplitude: 0.3, frequency: 3 Hz}]}}}"}},
         {}});
    SimulationOptions options;
    options.tracking = true;
    double square = 0;
    const SimulationReport report = simulation_report(spec, options);
    for (const SimulatedSignal& s : report.simulation.results[1]) square += s.tracking_rms * s.tracking_rms;
    return std::sqrt(square);
  };
  EXPECT_NEAR(length("tip") / length("base"), 1, 1e-12);
}

TEST(Cutoffs, TheLeastTotalIsBetweenNoiseAndLag) {
  Spec spec = tracked_slider({{"encoders", "{'*': {resolution: 1 mm}}"}});
  SimulationReport report{spec, {}, 1, {}, CutoffSearch{"v", cutoffs_between(5, 200, 9)}};
  EXPECT_EQ(report.cutoffs->values.front(), 5);
  EXPECT_EQ(report.cutoffs->values.back(), 200);
  report.spec.filters.clear();
  for (const double cutoff : report.cutoffs->values)
    report.spec.filters.push_back(
        tracked_slider({{"filters.v.lowpass.cutoff", std::to_string(cutoff) + " Hz"}}).filters[0]);
  SimulationOptions options;
  options.tracking = true;
  report.simulation = simulation_report(report.spec, options).simulation;
  const std::vector<CutoffChoice> choices = cutoff_choices(report);
  const std::size_t best = best_of(choices);
  EXPECT_GT(best, 0u);
  EXPECT_LT(best, choices.size() - 1);
  for (std::size_t i = 1; i < choices.size(); ++i) {
    EXPECT_GT(choices[i].noise, choices[i - 1].noise);
    EXPECT_LT(choices[i].tracking, choices[i - 1].tracking);
    EXPECT_LE(choices[best].total, choices[i].total);
  }
}

}  // namespace
}  // namespace qerr
