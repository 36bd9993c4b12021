#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// References whose noise is as large as the encoder's counts, such as trackers, in motions with corners,
/// rests and constant speeds.
namespace qerr {
namespace {

/// Forth and back at a constant speed, with or without rests at the ends.
Column forth_and_back(const Column& time, double period, double rest, double range) {
  return time.unaryExpr([&](double t) {
    const double s = std::fmod(t / period, 1.0), half = s < 0.5 ? 2 * s : 2 - 2 * s;
    return range * std::clamp((half - rest) / (1 - 2 * rest), 0.0, 1.0);
  });
}

/// One of five motions, over 20 to 3,000 counts, with a reference of 0.3 to 3 counts.
Machine with_noise(unsigned seed) {
  Machine m(seed);
  const double range = m.resolution * 20 * std::pow(150, m.between(0, 1)), duration = m.rows / m.rate,
               period = duration / m.between(1.5, 6);
  m.noise = m.resolution * 0.3 * std::pow(10, m.between(0, 1));
  if (seed % 5 == 0) m.path = forth_and_back(m.time, period, 0, range);
  if (seed % 5 == 1) m.path = forth_and_back(m.time, period, m.between(0.1, 0.3), range);
  if (seed % 5 == 2) m.path = range * (m.time / duration - 0.3);  // of one through zero, a scale is a drift
  if (seed % 5 == 3) m.path = 0.5 * range * (2 * std::numbers::pi * m.time / period).sin();
  if (seed % 5 == 4)
    m.path = 0.5 * range - 0.5 * range * (std::numbers::pi * forth_and_back(m.time, period, 0.3, 1)).cos();
  return m;
}

TEST(NoisyReference, OfACleanEncoderIsNoError) {
  constexpr int records = 60;
  int wrong = 0;
  std::string said;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Machine m = with_noise(seed);
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.path)));
    if (d.causes.empty() && d.unexplained.empty()) continue;
    ++wrong;
    said += "seed " + std::to_string(seed) + ":";
    for (const Cause& c : d.causes) said += ' ' + c.effect.type;
    for (const Unidentified& u : d.unexplained) said += ' ' + u.what;
    said += '\n';
  }
  EXPECT_LE(wrong, 2) << said;
}

TEST(NoisyReference, HidesNoErrorOfSeveralCounts) {
  constexpr int records = 20;
  int right = 0;
  std::string said;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Machine m = with_noise(seed);
    const double wide = m.path.maxCoeff() - m.path.minCoeff();
    const Column error = 10 * m.resolution * (m.path / wide);
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.path + error)));
    const bool found = std::any_of(d.causes.begin(), d.causes.end(),
                                   [](const Cause& c) { return c.effect.type == "scale"; }) ||
                       std::any_of(d.alternatives.begin(), d.alternatives.end(),
                                   [](const AlternativeCause& a) { return a.effect == "scale"; });
    right += found;
    if (found) continue;
    said += "seed " + std::to_string(seed) + ", " + std::to_string(wide / m.resolution) + " counts, noise " +
            std::to_string(m.noise / m.resolution) + ": " + std::string(name(d.verdict));
    for (const Cause& c : d.causes) said += ' ' + c.effect.type;
    for (const Unidentified& u : d.unexplained) said += ' ' + u.what;
    said += '\n';
  }
  EXPECT_GE(right, records - 1) << said;
}

TEST(NoisyReference, NamesNothingWhoseIntervalHoldsZero) {
  for (unsigned seed = 101; seed <= 120; ++seed) {
    Machine m = with_noise(seed);
    const Column error = m.resolution * m.between(0.2, 0.6) * (3 * m.path / m.path.abs().maxCoeff()).sin();
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.path + error)));
    for (const Cause& c : d.causes)
      for (const FoundParameter& p : c.parameters) {
        const bool size =
            p.name == "amplitude" || p.name == "scale" || p.name == "delay" || p.name == "offset";
        EXPECT_TRUE(!size || p.lower * p.upper > 0) << "seed " << seed << ", " << c.effect.type;
      }
  }
}

/// 25 to 80 poses with 3 to 11 rows of each, with or without time.
struct Poses {
  Machine machine;
  bool timed;

  explicit Poses(unsigned seed) : machine(seed), timed(seed % 2 == 0) {
    Machine& m = machine;
    const auto poses = static_cast<Eigen::Index>(m.between(25, 80)),
               repeats = static_cast<Eigen::Index>(m.between(3, 12));
    m.noise = m.resolution * m.between(0.02, 0.4);
    m.rows = static_cast<int>(poses * repeats);
    m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / 10;
    m.path.resize(m.rows);
    for (Eigen::Index i = 0; i < poses; ++i)
      m.path.segment(i * repeats, repeats).setConstant(m.between(-1.5, 1.5));
  }

  Diagnosis diagnosed(const Column& error) {
    std::vector<Written> columns{{LogSignal::counts, machine.counted(machine.path + error), 0},
                                 {LogSignal::reference, machine.reference()}};
    if (timed) columns.insert(columns.begin(), {LogSignal::time, machine.time});
    return diagnose(model_of(machine), {}, {}, log_of(columns));
  }
};

// The rows of a pose have one rounding error: as samples of their own they have high orders and scatter.
TEST(NoisyReference, OfRepeatedPosesIsNoError) {
  constexpr int records = 40;
  int wrong = 0;
  std::string said;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Poses p(seed);
    const Diagnosis d = p.diagnosed(Column::Zero(p.machine.rows));
    if (d.causes.empty() && d.unexplained.empty()) continue;
    ++wrong;
    said += "seed " + std::to_string(seed) + ": " + std::string(name(d.verdict));
    for (const Cause& c : d.causes) said += ' ' + c.effect.type;
    for (const Unidentified& u : d.unexplained) said += ' ' + u.what;
    said += '\n';
  }
  EXPECT_LE(wrong, 1) << said;
}

TEST(NoisyReference, OfRepeatedPosesHidesNoEccentricity) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Poses p(seed);
    const Diagnosis d = p.diagnosed(3 * p.machine.resolution * (p.machine.path + 0.3).sin());
    ASSERT_FALSE(d.causes.empty()) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "eccentricity") << seed;
  }
}

}  // namespace
}  // namespace qerr
