#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "qerr/effect/effect_kind.hpp"
#include "simulate/sensing.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

/// One revolute joint with an encoder of 4000 counts behind a gear of 20: quadrature, four counts per line.
OperationalModel one_joint() {
  OperationalModel m;
  m.chain.base = "base";
  m.chain.tip = "tip";
  ChainJoint joint;
  joint.name = "elbow";
  m.chain.joints = {joint};
  m.chain.independent = {{"elbow", JointType::revolute, {}, true}};
  Encoder encoder;
  encoder.resolution = 2 * pi / (4000 * 20);
  encoder.shaft_ratio = 20;
  encoder.counts_per_period = 4;
  m.transmission = {{encoder}, Eigen::MatrixXd::Identity(1, 1)};
  m.coordinates = {Coordinate::x};
  return m;
}

Motion motion(double seconds = 4) {
  return {1000, seconds, {}, {{0.3, 0, {{0.8, 0.31, 0.2}, {0.1, 1.3, 1}}, {}}}, {}};
}

double path(double t) {
  return 0.3 + 0.8 * std::sin(2 * pi * 0.31 * t + 0.2) + 0.1 * std::sin(2 * pi * 1.3 * t + 1);
}

struct Readings {
  std::vector<double> time, truth, counts, measured, reference, logged;
};

Readings record(const std::vector<Effect>& effects, double seconds = 4, std::uint64_t seed = 1,
                const OperationalModel& model = one_joint()) {
  Sensing sensing(model, motion(seconds), effects, {Eigen::VectorXd::Zero(1), seed});
  Readings r;
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(1000 * seconds); ++k) {
    const Reading& reading = sensing.read(k);
    r.time.push_back(reading.time);
    r.truth.push_back(reading.joint[0]);
    r.counts.push_back(reading.counts[0]);
    r.measured.push_back(reading.measured[0]);
    r.reference.push_back(reading.reference[0]);
    r.logged.push_back(reading.logged[0]);
  }
  return r;
}

const double delta = 2 * pi / (4000 * 20);

TEST(Sensing, IdealIsTheNearestCountOfTheTruePath) {
  const Readings r = record({});
  for (std::size_t k = 0; k < r.time.size(); ++k) {
    EXPECT_NEAR(r.truth[k], path(r.time[k]), 1e-13);
    EXPECT_LE(std::abs(r.measured[k] - r.truth[k]), 0.5 * delta * (1 + 1e-9));
    EXPECT_EQ(r.reference[k], r.truth[k]);
    EXPECT_EQ(r.counts[k], std::round(r.counts[k]));
  }
}

TEST(Effects, RejectANameThatIsNotAParameter) {
  for (const EffectKind& kind : effect_kinds()) {
    const Effect effect{std::string(kind.name), "elbow", {}, {}};
    EXPECT_THROW(effect.number("amplitud"), std::out_of_range) << kind.name;
    EXPECT_EQ(effect.number_or("amplitud", 7), 7) << kind.name;
    for (const Parameter& p : kind.parameters)
      EXPECT_EQ(effect.number(std::string(p.name)), p.fallback.value_or(0)) << kind.name << ' ' << p.name;
  }
}

/// Every effect of magnitude zero equals the ideal machine, bitwise.
TEST(Effects, OfMagnitudeZeroChangeNothing) {
  const Readings ideal = record({});
  const std::vector<Effect> none{
      {"offset", "elbow", {{"offset", 0}}, {}},
      {"scale", "elbow", {{"scale", 0}}, {}},
      {"eccentricity", "elbow", {{"amplitude", 0}, {"phase", 1}, {"order", 1}}, {}},
      {"transmission_error", "elbow", {{"amplitude", 0}, {"order", 2.5}}, {{"shaft", "joint"}}},
      {"subdivision_error", "elbow", {{"clipping", 1}}, {}},
      {"state_width", "elbow", {{"phase", 0}}, {}},
      {"missed_counts", "elbow", {{"counts", 0}, {"time", 1}}, {}},
      {"decoding", "elbow", {{"factor", 1}}, {}},
      {"backlash", "elbow", {{"gap", 0}}, {}},
      {"compliance", "elbow", {{"compliance", 0}}, {}},
      {"latency", "elbow", {{"delay", 0}}, {}},
      {"timing_jitter", "elbow", {{"sigma", 0}}, {}},
      {"clock_drift", "elbow", {{"rate", 0}}, {}},
      {"noise", "elbow", {{"sigma", 0}}, {}},
      {"drift", "elbow", {{"amplitude", 0}, {"coefficient", 0}}, {}},
      {"reference_error", "elbow", {{"amplitude", 0}, {"order", 50}}, {}},
      {"log_rounding", "elbow", {{"step", 0}}, {}},
  };
  for (const Effect& effect : none) {
    const Readings r = record({effect});
    EXPECT_EQ(r.counts, ideal.counts) << effect.type;
    EXPECT_EQ(r.reference, ideal.reference) << effect.type;
    EXPECT_EQ(r.logged, ideal.logged) << effect.type;
  }
}

/// An eccentric disc by geometry: its lines are at equal angles about its own centre, which has the distance
/// e from the shaft's centre; the head is at distance R from the shaft's centre.
TEST(Effects, EccentricityIsThatOfADisplacedDisc) {
  const double ratio = 0.004, phase = 0.7;
  const Readings r =
      record({{"eccentricity", "elbow", {{"amplitude", ratio / 20}, {"phase", phase}, {"order", 1}}, {}}});
  for (std::size_t k = 0; k < r.time.size(); k += 7) {
    const double shaft = 20 * r.truth[k];
    // Head on the x axis at distance 1; the disc's centre at ratio (cos b, sin b), rotating with the shaft.
    // The head is in direction -atan2(y, x) from that centre, and the disc has rotated by the shaft's
    // angle.
    const double b = shaft + phase;
    const double x = 1 - ratio * std::cos(b), y = ratio * std::sin(b);
    const double reading = (shaft + std::atan2(y, x)) / 20;
    EXPECT_NEAR(r.measured[k], reading, 0.5 * delta + 1.1 * ratio * ratio / 20);
  }
}

/// They are a Fourier series of the angle of one shaft.
TEST(Effects, OrdersOfAGearAdd) {
  const std::vector<Effect> orders{{"transmission_error", "elbow", {{"amplitude", 3e-3}, {"order", 2}}, {}},
                                   {"backlash", "elbow", {{"gap", 0}}, {}},
                                   {"transmission_error", "elbow", {{"amplitude", 2e-3}, {"order", 4}}, {}}};
  const Readings r = record(orders);
  for (std::size_t k = 0; k < r.time.size(); ++k) {
    const double sum = 3e-3 * std::sin(2 * 20 * r.truth[k]) + 2e-3 * std::sin(4 * 20 * r.truth[k]);
    EXPECT_LE(std::abs(r.measured[k] - r.truth[k] - sum), 0.5 * delta * (1 + 1e-9));
  }
}

TEST(Effects, TheOrderOfTheEntriesDoesNotMatter) {
  const double scale = 0.01, offset = 0.2, amplitude = 3e-3;
  std::vector<Effect> effects{{"offset", "elbow", {{"offset", offset}}, {}},
                              {"scale", "elbow", {{"scale", scale}}, {}},
                              {"eccentricity", "elbow", {{"amplitude", amplitude}, {"order", 1}}, {}}};
  std::ranges::sort(effects, {}, &Effect::type);
  do {
    const Readings r = record(effects);
    for (std::size_t k = 0; k < r.time.size(); k += 7) {
      const double disc = (1 + scale) * r.truth[k];
      const double reading = disc + amplitude * std::sin(20 * disc) + offset;
      EXPECT_LE(std::abs(r.measured[k] - reading), 0.5 * delta * (1 + 1e-9));
    }
  } while (std::ranges::next_permutation(effects, {}, &Effect::type).found);
}

/// Quadrature of two channels: A has edges at multiples of half a line, B a quarter of a line later plus the
/// phase error; every edge is counted.
TEST(Effects, StateWidthMovesTheEdgesOfTheSecondChannel) {
  const double phase = 0.6, line = 4 * delta, shift = phase / (2 * pi) * line;
  OperationalModel down = one_joint();
  down.transmission.encoders[0].rounding = Rounding::down;
  const Effect width{"state_width", "elbow", {{"phase", phase}}, {}};
  const std::vector<std::pair<Readings, double>> records{
      {record({width}), 0.5},
      {record({width}, 4, 1, down), 0.0},
      {record({width, {"truncation", "elbow", {}, {}}}), 0.0}};
  for (const auto& [r, before] : records) {
    // Edges between count k - 1 and k; those of odd k belong to B and are displaced.
    const auto edge = [&, by = before](long long k) {
      return (static_cast<double>(k) - by) * delta + (k % 2 != 0 ? shift : 0);
    };
    for (std::size_t i = 0; i < r.time.size(); ++i) {
      auto k = static_cast<long long>(std::floor(r.truth[i] / delta)) - 3;
      while (edge(k + 1) <= r.truth[i]) ++k;
      if (std::abs(edge(k) - r.truth[i]) < 1e-12 || std::abs(edge(k + 1) - r.truth[i]) < 1e-12) continue;
      EXPECT_EQ(r.counts[i], static_cast<double>(k)) << i;
    }
  }
}

/// Heydemann: the interpolator's atan2 of the two photodiodes' signals.
TEST(Effects, SubdivisionErrorIsTheArcTangentOfTheDistortedSignals) {
  OperationalModel model = one_joint();
  Encoder& encoder = model.transmission.encoders[0];
  encoder.counts_per_period = 1024;
  encoder.resolution = 2 * pi / (1024 * 64);
  encoder.shaft_ratio = 1;
  const double period = 2 * pi / 64;
  for (const double clip : {1.0, 0.7}) {
    const Readings r = record(
        {{"subdivision_error",
          "elbow",
          {{"offset_sin", 0.02}, {"offset_cos", -0.01}, {"gain", 0.03}, {"phase", 0.05}, {"clipping", clip}},
          {}}},
        4, 1, model);
    for (std::size_t k = 0; k < r.time.size(); k += 3) {
      const double angle = 2 * pi * r.truth[k] / period;
      double s = 1.03 * std::sin(angle + 0.05) + 0.02, c = std::cos(angle) - 0.01;
      if (clip < 1) s = std::clamp(s, -clip, clip), c = std::clamp(c, -clip, clip);
      const double turns = std::floor(angle / (2 * pi) + 0.5);
      double inside = std::atan2(s, c);
      // The line counter follows the true line.
      const double angle_read = 2 * pi * turns + inside;
      const double expected =
          (angle_read - 2 * pi * std::round((angle_read - angle) / (2 * pi))) * period / (2 * pi);
      EXPECT_NEAR(r.measured[k], expected, 0.51 * encoder.resolution);
    }
  }
}

/// A motor that drives the joint through a gap: it touches one of two flanks and keeps the contact at rest.
TEST(Effects, BacklashIsAPlayOperatorThatHoldsAtRest) {
  const double gap = 20 * delta;
  const Readings r = record({{"backlash", "elbow", {{"gap", gap}}, {}}});
  double motor = path(0);
  for (std::size_t k = 1; k < r.time.size(); ++k) {
    const double joint = r.truth[k];
    if (joint > r.truth[k - 1]) motor = joint + gap / 2;
    if (joint < r.truth[k - 1]) motor = joint - gap / 2;
    EXPECT_NEAR(r.measured[k], motor, 0.51 * delta);
  }
}

/// Away from its turning points the joint moves one way, however jitter exchanges the instants of readings.
TEST(Effects, JitterDoesNotTurnTheJointRoundWithinItsPlay) {
  const double gap = 2000 * delta, jitter = 1e-3;  // a sample's time
  const Effect jittered{"timing_jitter", "elbow", {{"sigma", jitter}}, {}};
  const Readings r = record({jittered, {"backlash", "elbow", {{"gap", gap}}, {}}}),
                 without = record({jittered});
  const auto direction = [&](double t) { return path(t + 1e-6) > path(t - 1e-6) ? 1 : -1; };
  for (std::size_t k = 2; k < r.time.size(); ++k) {
    const double t = r.time[k];
    if (direction(t - 8 * jitter) != direction(t + 6 * jitter)) continue;
    EXPECT_NEAR(r.measured[k] - without.measured[k], direction(t) * gap / 2, 1.02 * delta);
  }
}

TEST(Effects, OfTheClockSampleThePathAtOtherTimes) {
  const Readings late = record({{"latency", "elbow", {{"delay", 0.0123}}, {}}});
  const Readings fast = record({{"clock_drift", "elbow", {{"rate", 1e-3}}, {}}});
  for (std::size_t k = 20; k < late.time.size(); ++k) {
    EXPECT_NEAR(late.measured[k], path(late.time[k] - 0.0123), 0.51 * delta);
    EXPECT_NEAR(fast.measured[k], path(fast.time[k] * 1.001), 0.51 * delta);
    EXPECT_NEAR(late.reference[k], path(late.time[k]), 1e-12);
  }
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(Effects, RandomOnesHaveTheirSigmaAndDependOnTheSeed) {
  const Effect noise{"noise", "elbow", {{"sigma", 5 * delta}}, {}};
  const Readings r = record({noise}, 40, 1), other = record({noise}, 40, 2);
  EXPECT_NEAR(rms(r.measured, r.truth) / (delta * std::sqrt(25 + 1.0 / 12)), 1, 0.02);
  EXPECT_NE(r.counts, other.counts);
  EXPECT_EQ(r.counts, record({noise}, 40, 1).counts);
  const Readings jitter = record({{"timing_jitter", "elbow", {{"sigma", 1e-3}}, {}}}, 40);
  double speed = 0;
  for (const double t : jitter.time) speed += std::pow((path(t + 1e-5) - path(t - 1e-5)) / 2e-5, 2);
  speed = std::sqrt(speed / static_cast<double>(jitter.time.size()));
  EXPECT_NEAR(rms(jitter.measured, jitter.truth) / (1e-3 * speed), 1, 0.03);
}

TEST(Effects, OfTheDecoderActOnIntegerCounts) {
  const Readings ideal = record({});
  const Readings missed = record({{"missed_counts", "elbow", {{"counts", -7}, {"time", 1.5}}, {}}});
  const Readings half = record({{"decoding", "elbow", {{"factor", 0.5}}, {}}});
  const Readings wrapped = record({{"rollover", "elbow", {{"modulus", 4096}}, {}}});
  const Readings down = record({{"truncation", "elbow", {}, {}}});
  for (std::size_t k = 0; k < ideal.time.size(); ++k) {
    EXPECT_EQ(missed.counts[k], ideal.counts[k] + (ideal.time[k] >= 1.5 ? -7 : 0));
    EXPECT_NEAR(half.counts[k], ideal.counts[k] / 2, 0.5);
    EXPECT_EQ(half.counts[k], std::round(half.counts[k]));
    EXPECT_LT(wrapped.counts[k], 2048);
    EXPECT_GE(wrapped.counts[k], -2048);
    EXPECT_EQ(std::fmod(wrapped.counts[k] - ideal.counts[k], 4096), 0);
    EXPECT_EQ(down.counts[k], std::floor(down.truth[k] / delta));
  }
}

TEST(Effects, OfTheFileAndTheReferenceDoNotChangeTheCounts) {
  const Readings ideal = record({});
  const Readings rounded = record({{"log_rounding", "elbow", {{"step", 1e-3}}, {}}});
  const Readings wrong =
      record({{"reference_error", "elbow", {{"amplitude", 1e-3}, {"phase", 0.4}, {"order", 50}}, {}}});
  EXPECT_EQ(rounded.counts, ideal.counts);
  EXPECT_EQ(wrong.counts, ideal.counts);
  for (std::size_t k = 0; k < ideal.time.size(); ++k) {
    EXPECT_NEAR(rounded.logged[k] / 1e-3, std::round(rounded.logged[k] / 1e-3), 1e-9);
    EXPECT_NEAR(rounded.logged[k], ideal.logged[k], 0.5e-3 * (1 + 1e-9));
    EXPECT_NEAR(wrong.reference[k], wrong.truth[k] + 1e-3 * std::sin(50 * wrong.truth[k] + 0.4), 1e-12);
  }
}

}  // namespace
}  // namespace qerr
