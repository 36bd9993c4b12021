#include "simulate/unwrap.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "support/log_file.hpp"

namespace qerr {
namespace {

using ReadLog = testing::LogFile;

using std::numbers::pi;

double wrapped(double x, double turn, double from) { return x - turn * std::floor((x - from) / turn); }

TEST(Unwrap, RestoresEveryPathWhoseVelocityChangesByLessThanAQuarterTurnPerSample) {
  std::mt19937_64 dice(3);
  std::uniform_real_distribution<double> change(-0.2, 0.2), start(-5, 5);
  for (int run = 0; run < 200; ++run) {
    const double turn = run % 2 ? 2 * pi : 16384, from = start(dice) * turn;
    Unwrap unwrap = Unwrap::of_angle(turn);
    double x = start(dice) * turn, v = 0, offset = 0;
    for (int i = 0; i < 500; ++i) {
      // the velocity varies up to 0.7 revolutions per sample, for which the nearest revolution is wrong
      const double next = v + change(dice) * turn;
      if (i > 0 && std::abs(next) < 0.7 * turn) v = next;
      x += v;
      const double u = unwrap(wrapped(x, turn, from));
      if (i == 0) offset = x - u;
      ASSERT_NEAR(u, x - offset, 1e-9 * turn) << run << ' ' << i;
    }
    EXPECT_FALSE(unwrap.contradicted());
  }
}

/// A reading far off, of any size, costs itself and nothing after it; of a turn and a reading, only the turn
/// is counted.
TEST(Unwrap, DisregardsSingleReadingsFarOff) {
  std::mt19937_64 dice(5);
  std::uniform_real_distribution<double> start(-5, 5), size(-1.5, 1.5), phase(0, 6);
  for (int run = 0; run < 400; ++run) {
    const double turn = run % 2 ? 2 * pi : 16384, from = start(dice) * turn;
    const double swing = run % 4 < 2 ? 0.3 * turn : 2 * turn, at = phase(dice);
    const double off = (run % 8 == 0 ? 100 : 1) * size(dice) * turn;
    if (std::abs(std::abs(off / turn) - 1) < 0.07) continue;  // looks like a wrap
    Unwrap unwrap = Unwrap::of_angle(turn);
    const auto path = [&](int i) { return swing * std::sin(0.02 * i + at); };
    const int cell = 20 + run % 400;
    double offset = 0;
    for (int i = 0; i < 500; ++i) {
      const double u = unwrap(wrapped(path(i), turn, from) + (i == cell ? off : 0));
      if (i == 0) offset = path(0) - u;
      if (i == cell) continue;
      ASSERT_NEAR(u, path(i) - offset, 1e-9 * turn) << run << ' ' << i << ' ' << off / turn;
    }
  }
}

TEST(Unwrap, KeepsAJumpOtherThanARevolution) {
  for (const double jump : {0.3, -0.5, 0.7, -0.74, 2.0, -3.0}) {
    Unwrap unwrap = Unwrap::of_angle(1);
    for (int i = 0; i < 20; ++i) {
      const double x = 0.001 * i + (i > 9 ? jump : 0);
      ASSERT_EQ(unwrap(x), x) << jump;
    }
    EXPECT_EQ(unwrap.turns(), 0);
  }
}

TEST(Unwrap, KeepsAJumpOfARevolutionOfAMultiturnSignal) {
  Unwrap unwrap = Unwrap::of_angle(1);
  for (int i = 0; i < 40; ++i) {
    const double x = 0.1 * i - (i > 20 ? 1 : 0);
    ASSERT_EQ(unwrap(x), x);
  }
}

TEST(Unwrap, ReportsIfLaterSamplesContradictAWrap) {
  Unwrap unwrap = Unwrap::of_angle(1);
  for (int i = 0; i < 9; ++i) unwrap(0.1 * i);
  unwrap(-0.1);
  EXPECT_EQ(unwrap.turns(), 1);
  EXPECT_FALSE(unwrap.contradicted());
  for (int i = 0; i < 5; ++i) unwrap(-0.1 - 0.1 * i);
  EXPECT_TRUE(unwrap.contradicted());
}

/// A wrist with three revolutions; its counts and its reference wrap at different angles.
std::string turning_wrist(double turn_of_counts, double from) {
  std::string text = "time [s],wrist.counts,wrist.reference [rad],wrist.command [rad]\n";
  for (int i = 0; i < 300; ++i) {
    const double angle = 1 + 6 * pi * i / 300;
    const double counts = wrapped(std::round(angle / (2 * pi) * 16384), turn_of_counts, 0);
    text += std::to_string(0.01 * i) + ',' + std::to_string(static_cast<long>(counts)) + ',' +
            std::to_string(wrapped(angle, 2 * pi, from)) + ',' + std::to_string(angle) + '\n';
  }
  return text;
}

TEST_F(ReadLog, UnwrapsReferencesAndAbsoluteEncodersWithAWarning) {
  spec = spec_with("'*': {bits: 14}, lift: {resolution: 10 um}");
  for (const LogOptions& options : {LogOptions{}, LogOptions{.block_rows = 7}}) {
    const Log log = read(turning_wrist(16384, -pi), options);
    const auto& counts = log.columns[1].wraps;
    const auto& reference = log.columns[2].wraps;
    EXPECT_EQ(counts.count, 3u);
    EXPECT_EQ(counts.first_row, 85u);  // 1 + 6 pi 85/300 is beyond 2 pi
    EXPECT_DOUBLE_EQ(counts.first_time, 0.85);
    EXPECT_EQ(reference.count, 3u);
    EXPECT_EQ(reference.first_row, 35u);
    EXPECT_EQ(reference.start, 0);
    EXPECT_EQ(log.columns[3].wraps.count, 0u);
    for (Eigen::Index i = 0; i < 300; ++i) {
      const double angle = 1 + 6 * pi * static_cast<double>(i) / 300;
      ASSERT_EQ(values(log, LogSignal::counts, 3)[i], std::round(angle / (2 * pi) * 16384));
      ASSERT_NEAR(values(log, LogSignal::reference, 3)[i], angle, 1e-6);
    }
  }
}

TEST_F(ReadLog, MovesAReferenceToTheRevolutionOfTheMeasuredPosition) {
  spec = spec_with("'*': {bits: 14}, lift: {resolution: 10 um}");
  for (const Eigen::Index rows : {8192, 7}) {
    const Log log = read(turning_wrist(16384, 4 * pi), {.block_rows = rows});
    EXPECT_EQ(log.columns[2].wraps.start, -2);
    for (Eigen::Index i = 0; i < 300; ++i)
      ASSERT_NEAR(values(log, LogSignal::reference, 3)[i], 1 + 6 * pi * static_cast<double>(i) / 300, 1e-6);
  }
}

TEST_F(ReadLog, CountsNoTurnOfAReadingFarOff) {
  std::string text = "time [s],wrist.counts,wrist.reference [rad]\n";
  for (int i = 0; i < 300; ++i) {
    const double angle = std::sin(0.02 * i);
    text += std::to_string(0.01 * i) + ',' + std::to_string(std::lround(angle / (2 * pi) * 4096)) + ',' +
            std::to_string(angle + (i == 0 || i == 120 ? 5 : 0)) + '\n';
  }
  const Log log = read(text);
  EXPECT_NEAR(values(log, LogSignal::reference, 3)[120], std::sin(2.4) + 5, 1e-6);
  for (Eigen::Index i = 1; i < 300; ++i) {
    if (i == 120) continue;
    ASSERT_NEAR(values(log, LogSignal::reference, 3)[i], std::sin(0.02 * static_cast<double>(i)), 1e-6) << i;
  }
}

TEST_F(ReadLog, NamesPositionsWhoseColumnsAreMisspelt) {
  const auto misspelt = [&](const std::string& header) {
    const std::string cells(header.find(',') == header.npos ? ",1,2\n" : ",1,2,3\n");
    return read("time [s],wrist.counts," + header + "\n0" + cells + "1" + cells).misspelt;
  };
  using Names = std::vector<std::string>;
  for (const std::string name : {"wrist.refrence", "wrist.Reference [rad]", "wrist.ref", "Wrist.reference"})
    EXPECT_EQ(misspelt(name), Names{"wrist"}) << name;
  for (const std::string name : {"wrist.reference", "wrist.Effort", "wrist9.reference", "tip.rz", "notes"})
    EXPECT_EQ(misspelt(name), Names{}) << name;
  EXPECT_EQ(misspelt("lift.Counts,lift.Reference"), (Names{"lift", "lift"}));
}

TEST_F(ReadLog, KeepsTheJumpOfAnIncrementalCounter) {
  for (const std::string encoder :
       {"{counts_per_rev: 16384}", "{periods_per_rev: 2, interpolation_bits: 13}"}) {
    spec = spec_with("'*': " + encoder + ", lift: {resolution: 10 um}");
    const Log log = read(turning_wrist(16384, -pi));
    EXPECT_EQ(log.columns[1].wraps.count, 0u);
    EXPECT_LT(values(log, LogSignal::counts, 3).maxCoeff(), 16384);
    EXPECT_EQ(log.columns[2].wraps.count, 3u);
  }
  spec = spec_with("'*': {periods_per_rev: 1, interpolation_bits: 14}, lift: {resolution: 10 um}");
  EXPECT_EQ(read(turning_wrist(16384, -pi)).columns[1].wraps.count, 3u);
}

TEST_F(ReadLog, DoesNotUnwrapPrismaticJoints) {
  std::string text = "time [s],lift.counts,lift.reference [m]\n";
  for (int i = 0; i < 10; ++i)
    text += std::to_string(i) + ",0," + std::to_string(i < 5 ? 0.0 : 2 * pi) + '\n';
  EXPECT_EQ(read(text).columns[2].wraps.count, 0u);
}

TEST_F(ReadLog, InATableTheReferenceFollowsTheMeasuredPositionInAnyOrderOfRows) {
  spec = spec_with("'*': {bits: 14}, lift: {resolution: 10 um}");
  std::vector<int> order(16384 / 16);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(16 * i);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(8));
  std::string text = "wrist.counts,wrist.reference [rad]\n";
  const auto angle = [](int counts) {
    return 2 * pi * counts / 16384 + 0.04 * std::sin(2 * pi * counts / 16384);
  };
  for (const int counts : order)
    text += std::to_string(counts) + ',' + std::to_string(wrapped(angle(counts) + 0.3, 2 * pi, -1)) + '\n';
  for (const Eigen::Index rows : {8192, 10}) {
    const Log log = read(text, {.block_rows = rows});
    for (std::size_t i = 0; i < order.size(); ++i)
      ASSERT_NEAR(values(log, LogSignal::reference, 3)[static_cast<Eigen::Index>(i)], angle(order[i]) + 0.3,
                  1e-6);
    EXPECT_GT(log.columns[1].wraps.count, 0u);
  }
}

/// Positions over several turns in random order, of one or the other sensor modulo a turn.
TEST_F(ReadLog, InATableTheSensorThatWrapsFollowsTheOther) {
  std::mt19937_64 dice(5);
  std::uniform_real_distribution<double> anywhere(-3.4 * pi, 5.2 * pi);
  for (const bool absolute : {false, true})
    for (const double scale : {1.0, 1.01}) {
      spec = spec_with(std::string("'*': ") + (absolute ? "{bits: 14}" : "{counts_per_rev: 16384}") +
                       ", lift: {resolution: 10 um}");
      std::vector<double> angles;
      std::string text = "wrist.counts,wrist.reference [rad]\n";
      for (int i = 0; i < 60; ++i) {
        angles.push_back(anywhere(dice));
        const double counts = std::round(scale * angles.back() / (2 * pi) * 16384);
        text += std::to_string(std::lround(absolute ? wrapped(counts, 16384, 0) : counts)) + ',' +
                std::to_string(absolute ? angles.back() : wrapped(angles.back(), 2 * pi, -pi)) + '\n';
      }
      const Log log = read(text);
      const auto counts = values(log, LogSignal::counts, 3), reference = values(log, LogSignal::reference, 3);
      for (Eigen::Index i = 0; i < 60; ++i) {
        ASSERT_NEAR(reference[i], angles[static_cast<std::size_t>(i)], 1e-6) << absolute << scale << i;
        ASSERT_NEAR(counts[i] / 16384 * 2 * pi, scale * reference[i], 3e-4) << absolute << scale << i;
      }
    }
}

/// The joint goes from one position to the next between two rows, by nearly a turn, and dwells.
TEST_F(ReadLog, TakesALeapOfBothSensorsForNoWrap) {
  std::string text = "time [s],wrist.counts,wrist.reference [rad]\n";
  const double angles[] = {0.3, 1.5, -2.9, 2.8, 0.2, -3.0, 2.9, 1.1};
  for (int i = 0; i < 80; ++i) {
    const double angle = angles[i / 10];
    text += std::to_string(0.1 * i) + ',' + std::to_string(std::lround(angle / (2 * pi) * 4096)) + ',' +
            std::to_string(angle) + '\n';
  }
  spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}");
  const Log log = read(text);
  for (Eigen::Index i = 0; i < 80; ++i)
    ASSERT_NEAR(values(log, LogSignal::reference, 3)[i], angles[i / 10], 1e-6) << i;
}

/// In which of three turns the shaft of an absolute encoder starts is not known.
TEST_F(ReadLog, MovesAnAbsoluteEncoderBehindAGearToTheTurnOfTheReference) {
  spec = spec_with("'*': {bits: 14, gear_ratio: 3}, lift: {resolution: 10 um}");
  std::string text = "time [s],wrist.counts,wrist.reference [rad]\n";
  for (int i = 0; i < 100; ++i) {
    const double angle = 2.8 + 0.01 * i;
    text += std::to_string(0.1 * i) + ',' +
            std::to_string(std::lround(wrapped(std::round(3 * angle / (2 * pi) * 16384), 16384, 0))) + ',' +
            std::to_string(angle) + '\n';
  }
  const Log log = read(text);
  EXPECT_EQ(log.columns[1].wraps.start, 1);
  for (Eigen::Index i = 0; i < 100; ++i)
    ASSERT_NEAR(values(log, LogSignal::counts, 3)[i] / 3 / 16384 * 2 * pi,
                2.8 + 0.01 * static_cast<double>(i), 1e-4);
}

TEST(Unwrap, TakesAJumpByAWholeTurnForNoWrapOfACounter) {
  constexpr double turn = 4096;
  Unwrap at_rest = Unwrap::of_counter(turn), on_the_edge = Unwrap::of_counter(turn);
  for (int k = 0; k < 50; ++k) {
    // Values 1000 and 5096 are not both of one turn.
    EXPECT_EQ(at_rest(k < 25 ? 1000 : 1000 + turn), k < 25 ? 1000 : 1000 + turn);
    EXPECT_EQ(on_the_edge(k < 25 ? 0 : turn - 1), k < 25 ? 0 : -1);
  }
}

}  // namespace
}  // namespace qerr
