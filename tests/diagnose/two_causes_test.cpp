#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

/// Every parameter of a diagnosis' causes, with its interval.
std::map<std::string, FoundParameter> found_by(const Diagnosis& d) {
  std::map<std::string, FoundParameter> found;
  for (const Cause& c : d.causes)
    for (const FoundParameter& p : c.parameters) found[c.effect.type + ' ' + p.name] = p;
  return found;
}

Machine swinging(unsigned seed) {
  Machine m(seed);
  m.rate = 200, m.rows = 2400, m.resolution = 5e-5, m.noise = 0.02 * m.resolution;
  m.sines = {{1.1, {2 * std::numbers::pi * 0.175, 0}}, {0.97, {2 * std::numbers::pi * 0.499, 0}}};
  m.centre = 0;
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = m.along(m.time);
  return m;
}

/// A wrong ratio multiplies a reading that is late.
TEST(TwoCauses, IntervalsBesideAScaleHoldTheDelay) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m = swinging(seed);
    const double scale = 1.5e-3, delay = 0.8e-3;
    const Diagnosis d =
        diagnose(model_of(m), {}, {}, log_of(m, m.counted((1 + scale) * m.along(m.time - delay))));
    const auto found = found_by(d);
    ASSERT_TRUE(found.contains("latency delay") && found.contains("scale scale")) << seed;
    EXPECT_LE(found.at("latency delay").lower, delay) << seed;
    EXPECT_GE(found.at("latency delay").upper, delay) << seed;
  }
}

/// A shape that leaves white rounding hides no offset of half a count, however large it is.
TEST(TwoCauses, HalfACountIsNamedBesideAnExactSine) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m = swinging(seed);
    const double amplitude = 300 * m.resolution;
    const Column read = m.path + amplitude * (m.path + 1).sin() - 0.5 * m.resolution;
    const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, m.counted(read))));
    ASSERT_TRUE(found.contains("eccentricity amplitude")) << seed;
    EXPECT_NEAR(found.at("eccentricity amplitude").value, amplitude, 0.05 * m.resolution) << seed;
  }
}

/// White noise of the encoder leaves no structure, which an order that is right has to leave none of.
TEST(TwoCauses, AnOrderOfOneTurnIsNamedBesideNoise) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m = swinging(seed);
    OperationalModel model = model_of(m);
    model.transmission.encoders[0].shaft_ratio = 6.3 / (m.path.maxCoeff() - m.path.minCoeff());
    const double ratio = model.transmission.encoders[0].shaft_ratio;
    Column read = m.path + 3 * m.resolution * (ratio * m.path + 1).sin();
    for (double& x : read) x += 7 * m.resolution * m.normal();
    const auto found = found_by(diagnose(model, {}, {}, log_of(m, m.counted(read))));
    EXPECT_TRUE(found.contains("eccentricity amplitude") && found.contains("noise sigma")) << seed;
  }
}

/// Of signals that are clipped, and have no other fault, the level is a parameter that nothing scales.
TEST(TwoCauses, ClippingAloneIsNamed) {
  Machine m = swinging(1);
  OperationalModel model = model_of(m);
  model.transmission.encoders[0].counts_per_period = 4096;
  const double unit = 4096 * m.resolution / (2 * std::numbers::pi);
  const Column angle = m.path / unit, sine = angle.sin().max(-0.8).min(0.8),
               cosine = angle.cos().max(-0.8).min(0.8);
  Column read = m.path;
  for (Eigen::Index k = 0; k < m.rows; ++k)
    read[k] += unit * std::remainder(std::atan2(sine[k], cosine[k]) - angle[k], 2 * std::numbers::pi);
  const auto found = found_by(diagnose(model, {}, {}, log_of(m, m.counted(read))));
  ASSERT_TRUE(found.contains("subdivision_error clipping"));
  EXPECT_NEAR(found.at("subdivision_error clipping").value, 0.8, 0.01);
}

/// A time constant is where the readings have it, to its interval.
TEST(TwoCauses, IntervalsOfADriftHoldItsTimeConstant) {
  int inside = 0;
  constexpr int records = 8;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Machine m = swinging(seed);
    const double constant = m.between(2, 5);
    const Column read = m.path + 2e-3 * (1 - (-m.time / constant).exp());
    const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, m.counted(read))));
    ASSERT_TRUE(found.contains("drift time_constant")) << seed;
    const FoundParameter p = found.at("drift time_constant");
    inside += p.lower <= constant && constant <= p.upper;
  }
  EXPECT_GE(inside, records - 1);
}

/// The joint's angle has no play: its periodic error is not displaced by one, as that of the disc would be.
TEST(TwoCauses, APeriodicErrorOfTheJointIsExactBesideItsPlay) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m = swinging(seed);
    const double gap = 0.05, amplitude = 0.04;
    Column read = m.path + amplitude * (3 * m.path + 1).sin();
    for (Eigen::Index k = 1; k < m.rows; ++k) read[k] += m.path[k] > m.path[k - 1] ? gap / 2 : -gap / 2;
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(read)));
    const auto found = found_by(d);
    ASSERT_TRUE(found.contains("backlash gap") && found.contains("transmission_error amplitude")) << seed;
    EXPECT_NEAR(found.at("backlash gap").value, gap, 2e-3 * gap) << seed;
    EXPECT_NEAR(found.at("transmission_error amplitude").value, amplitude, 2e-3 * amplitude) << seed;
    EXPECT_LT(d.gain.rms_after, 0.32 * m.resolution) << seed;
  }
}

/// Where the joint has hardly moved since it turned round, a reading multiplied by a ratio below one has not
/// crossed the whole play.
TEST(TwoCauses, APlayIsCrossedAlsoBesideAScale) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m = swinging(seed);
    const double gap = 0.012, scale = -0.03;
    Column read = m.path;
    for (Eigen::Index k = 1; k < m.rows; ++k) read[k] += m.path[k] > m.path[k - 1] ? gap / 2 : -gap / 2;
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted((1 + scale) * read)));
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    EXPECT_LT(d.gain.rms_after, 0.32 * m.resolution) << seed;
  }
}

/// The time of a loss is told by what the other causes leave.
TEST(TwoCauses, ALossIsBetweenItsRowsBesideAScale) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m = swinging(seed);
    const double time = m.between(5, 7);
    const Column read = m.counted(1.03 * m.path) + 9 * (m.time >= time).cast<double>();
    const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, read)));
    ASSERT_TRUE(found.contains("missed_counts time")) << seed;
    EXPECT_NEAR(found.at("missed_counts time").value, time, 1 / m.rate) << seed;
  }
}

/// A drift displaces the lines of the disc.
TEST(TwoCauses, TheGainOfALineIsThatOfADriftingDisc) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m = swinging(seed);
    const double period = 64 * m.resolution, gain = -0.05, constant = 2.8;
    const Column disc = m.path + 10 * m.resolution * (1 - (-m.time / constant).exp());
    const Column read = disc.unaryExpr([&](double x) {
      const double angle = 2 * std::numbers::pi * x / period;
      const double shown = std::atan2((1 + gain) * std::sin(angle), std::cos(angle));
      return x + std::remainder(shown - angle, 2 * std::numbers::pi) * period / (2 * std::numbers::pi);
    });
    OperationalModel model = model_of(m);
    model.transmission.encoders[0].counts_per_period = 64;
    const auto found = found_by(diagnose(model, {}, {}, log_of(m, m.counted(read))));
    ASSERT_TRUE(found.contains("subdivision_error gain") && found.contains("drift time_constant")) << seed;
    EXPECT_NEAR(std::abs(found.at("subdivision_error gain").value), -gain, 0.003) << seed;
    EXPECT_NEAR(found.at("drift time_constant").value, constant, 0.15) << seed;
  }
}

/// Behind a loss of an odd number of counts the disc's edges are where they were.
TEST(TwoCauses, ALossOfCountsDoesNotHideUnequalStates) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m = swinging(seed);
    m.resolution = 2e-3, m.noise = 0.02 * m.resolution;
    const double shift = 0.3;  // of every second edge [counts]
    const Column read = m.path.unaryExpr([&](double x) {
      const double below = std::floor(x / m.resolution + 0.5);  // edges at k - 1/2, the odd ones later
      return std::fmod(below, 2) != 0 && x / m.resolution + 0.5 - below < shift ? below - 1 : below;
    });
    const Column losing = read - 23 * (m.time > 6.4).cast<double>();
    OperationalModel model = model_of(m);
    model.transmission.encoders[0].counts_per_period = 4;
    const auto found = found_by(diagnose(model, {}, {}, log_of(m, losing)));
    ASSERT_TRUE(found.contains("state_width phase")) << seed;
    EXPECT_NEAR(found.at("state_width phase").value, shift * std::numbers::pi / 2, 0.1) << seed;
  }
}

/// On one sweep at constant speed time and position are one; a loss repeats with neither, and is found soon.
TEST(OneWay, ALossOfCountsIsFound) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m = swinging(seed);
    m.noise = 0.3 * m.resolution, m.path = 0.7 * m.time;
    const double time = m.between(4, 8);
    const Column losing = m.counted(m.path) - 39 * (m.time >= time).cast<double>();
    const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, losing)));
    ASSERT_TRUE(found.contains("missed_counts counts")) << seed;
    EXPECT_NEAR(found.at("missed_counts counts").value, -39, 0.5) << seed;
    EXPECT_NEAR(found.at("missed_counts time").value, time, 1 / m.rate) << seed;
  }
}

/// Lost counts are those of the spec, also where readings show every count twice, or some of them.
TEST(TwoCauses, CountsAreLostBeforeTheyAreDecoded) {
  for (const double lost : {32.0, 33.0})
    for (const double beside : {0.0, 1.0}) {  // an odd reading, so that half counts are read
      Machine m = swinging(1);
      Column read = 2 * (m.counted(m.path) - lost * (m.time >= 6).cast<double>());
      read[m.rows / 3] += beside;
      const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, read)));
      ASSERT_TRUE(found.contains("missed_counts counts")) << lost;
      EXPECT_NEAR(found.at("missed_counts counts").value, -lost, 0.5) << beside;
    }
}

}  // namespace
}  // namespace qerr
