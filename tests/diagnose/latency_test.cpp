#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnose/record/with_effects.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

TEST(PathAsRead, IsThePathAtTheInstantOfTheClocks) {
  const double delay = 0.0137, rate = 1e-3;
  Evidence e;
  e.joint = "a";
  e.time = Eigen::ArrayXd::LinSpaced(401, 0, 4);
  e.path = (2 * e.time).sin();
  e.velocity = 2 * (2 * e.time).cos();
  PathAsRead path(e, {{"latency", "a", {{"delay", delay}}, {}},
                      {"clock_drift", "a", {{"rate", rate}}, {}},
                      {"latency", "another", {{"delay", 1}}, {}}});
  const Eigen::ArrayXd all = path.of_all_rows();
  for (const Eigen::Index row : {400, 17, 18, 3, 200}) {
    EXPECT_NEAR(path(row), std::sin(2 * (e.time[row] * (1 + rate) - delay)), 1e-8) << row;
    EXPECT_EQ(path(row), all[row]) << row;
  }
}

/// Tens of counts of delay: the square of the delay matters, and must not be taken for an error of the scale.
TEST(Latency, OfManyCountsIsTheOnlyCause) {
  for (unsigned seed = 1; seed <= 16; seed += 5) {
    Machine m(400 + seed);
    const double delay = (1 + 0.25 * seed) / m.rate;
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.along(m.time - delay))));
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "latency") << seed;
    EXPECT_TRUE(d.alternatives.empty()) << seed;
    EXPECT_NEAR(d.causes[0].effect.number("delay"), delay, 1e-3 * delay) << seed;
    EXPECT_LT(d.gain.counts_after, 0.45) << seed;
  }
}

/// At a reversal that is sharper than the delay is long, a late reading is late, and no friction.
TEST(Latency, OfSeveralRowsIsFoundBetweenSharpReversals) {
  Machine m(500);
  m.rate = 100, m.rows = 4000, m.resolution = 1.5e-5, m.noise = 0.1 * m.resolution;
  const auto triangle = [](const Column& t) {
    return Column(0.06 * (0.13 * 2 * std::numbers::pi * t).sin().asin());
  };
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = triangle(m.time);
  const double delay = 3 / m.rate;
  const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(triangle(m.time - delay))));
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_EQ(d.verdict, Verdict::explained);
  EXPECT_EQ(d.causes[0].effect.type, "latency");
  EXPECT_NEAR(d.causes[0].effect.number("delay"), delay, 1e-3 * delay);
}

/// A clock that drifts beside a delay of several rows, between sharp reversals: each is the other's at some
/// instant, and a reading is late by both.
TEST(Latency, OfSeveralRowsIsFoundBesideAClockDrift) {
  Machine m(800);
  m.rate = 200, m.rows = 6000, m.resolution = 1.5e-5, m.noise = 0.01 * m.resolution;
  const auto triangle = [](const Column& t) {
    return Column(0.06 * (0.13 * 2 * std::numbers::pi * t).sin().asin() + 0.004 * t.sin());
  };
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = triangle(m.time);
  const double delay = 8 / m.rate, rate = 1.2e-3;
  const Diagnosis d =
      diagnose(model_of(m), {}, {}, log_of(m, m.counted(triangle(m.time - delay + rate * m.time))));
  std::map<std::string, double> found;
  for (const Cause& c : d.causes)
    for (const auto& [parameter, value] : c.effect.numbers) found[c.effect.type + ' ' + parameter] = value;
  EXPECT_EQ(d.verdict, Verdict::explained);
  EXPECT_EQ(found.size(), 2U);
  EXPECT_NEAR(found["latency delay"], delay, 2e-3 * delay);
  EXPECT_NEAR(found["clock_drift rate"], rate, 2e-3 * rate);
  EXPECT_LT(d.gain.counts_after, 0.35);
}

/// A record that begins and ends in motion does not have what its clock reads before and behind it: noise of
/// the reference, carried on for several rows, is no further cause.
TEST(Latency, OfSeveralRowsInMotionIsTheOnlyCause) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m(900 + seed);
    m.rate = 250, m.rows = 3000, m.resolution = 1.5e-5, m.noise = 0.1 * m.resolution;
    m.sines = {{0.3, {2 * std::numbers::pi * 0.3, m.between(0, 6)}},
               {0.03, {2 * std::numbers::pi * 1.3, m.between(0, 6)}},
               {0.002, {2 * std::numbers::pi * 10, 0}}};
    m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
    m.path = m.along(m.time);
    const double delay = m.between(5, 11) / m.rate;
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.along(m.time - delay))));
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "latency") << seed;
    EXPECT_NEAR(d.causes[0].effect.number("delay"), delay, 1e-3 * delay) << seed;
    EXPECT_LT(d.gain.counts_after, 0.35) << seed;
  }
}

/// Where a play leaves what it drives, along a finely sampled path of the driving side.
Column driven(const Column& driving, double gap) {
  Column at = driving;
  for (Eigen::Index k = 1; k < at.size(); ++k)
    at[k] = std::clamp(at[k - 1], driving[k] - gap / 2, driving[k] + gap / 2);
  return at;
}

/// A late encoder on either side of a play: what drives the play is late, too.
TEST(Latency, OfPlayIsFoundWithIt) {
  constexpr int fine = 20;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(700 + seed);
    m.rate = 100, m.rows = 3000, m.noise = 0.05 * m.resolution;
    m.sines = {{0.9, {2 * std::numbers::pi * m.between(0.1, 0.3), m.between(0, 6)}},
               {0.12, {2 * std::numbers::pi * m.between(0.5, 1.2), m.between(0, 6)}}};
    m.resolution = 3e-5, m.noise = 0.05 * m.resolution;
    m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
    const double gap = m.between(4, 14) * m.resolution, delay = 1 / m.rate;
    const bool drives = seed % 2 == 0;  // the encoder's side
    // The delay is whole rows, and the path begins before the record.
    const Column times =
        Column::LinSpaced((m.rows + 100) * fine, -100 * fine, m.rows * fine - 1) / (m.rate * fine);
    const Column one = m.along(times), other = driven(one, gap);
    const auto rows = Eigen::seqN(100 * fine, m.rows, fine);
    const auto before = Eigen::seqN(99 * fine, m.rows, fine);
    m.path = (drives ? other : one)(rows);
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted((drives ? one : other)(before))));
    std::map<std::string, double> found;
    for (const Cause& c : d.causes)
      for (const auto& [parameter, value] : c.effect.numbers) found[c.effect.type + ' ' + parameter] = value;
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    EXPECT_NEAR(found["latency delay"], delay, 0.01 * delay) << seed;
    EXPECT_NEAR(found["backlash gap"], gap, 0.1 * gap) << seed << ' ' << gap / m.resolution;
  }
}

}  // namespace
}  // namespace qerr
