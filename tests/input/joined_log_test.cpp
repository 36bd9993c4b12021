#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/log_file.hpp"

namespace qerr {
namespace {

/// Logs in several files, wide or long.
class JoinedLog : public testing::LogFile {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return (folder / name).string();
  }
  std::string refused(const LogFiles& files) {
    try {
      read_log(files, spec);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }
  static std::vector<double> column(const Log& log, LogSignal signal) {
    const Eigen::ArrayXd all = values(log, signal);
    return {all.begin(), all.end()};
  }
};

using Doubles = std::vector<double>;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(JoinedLog, ALongFileHoldsTheLastValueOfEachSignal) {
  const Log log = read(
      "time [ms],signal,value\n"
      "0,shoulder.counts,1\n0,state,moving\n1,shoulder.counts,2\n2,shoulder.reference [deg],180\n"
      "3,shoulder.counts,3\n4,shoulder.counts,4\n4,shoulder.reference [deg],90\n");
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{0.002, 0.003, 0.004}));
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{2, 3, 4}));
  const double half = std::numbers::pi / 2;
  EXPECT_EQ(column(log, LogSignal::reference), (Doubles{2 * half, 2 * half, half}));
  ASSERT_EQ(log.warnings.size(), 3u);
  EXPECT_TRUE(has(log.warnings[0], "'state'"));
  EXPECT_TRUE(
      has(log.warnings[2], ": shoulder.counts in 1 of 3 rows, shoulder.reference [deg] in 1 of 3 rows"))
      << log.warnings[2];
  EXPECT_TRUE(has(log.warnings[1], "2 rows dropped at the beginning"));
}

TEST_F(JoinedLog, SignalsOneAfterTheOtherAreSortedByTime) {
  const Log log = read(
      "signal,unit,value,time [s]\nshoulder.counts,,1,0\nshoulder.counts,,2,1\n"
      "shoulder.reference,mrad,1000,0\n\"shoulder.reference\",mrad,\"2000\",1\n");
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{0, 1}));
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{1, 2}));
  EXPECT_EQ(column(log, LogSignal::reference), (Doubles{1, 2}));
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_TRUE(has(log.warnings[0], "sorted by time"));
}

TEST_F(JoinedLog, EachSignalOfALongFileHasItsOwnResolution) {
  const Log log = read(
      "time [s],signal,value\n0.001,shoulder.counts,1\n0.001,shoulder.measured [rad],0.25\n"
      "0.001,shoulder.reference [rad],0.2501\n");
  EXPECT_EQ(log.columns[static_cast<std::size_t>(*log.find(LogSignal::measured))].text.most_decimals, 2);
  EXPECT_EQ(log.columns[static_cast<std::size_t>(*log.find(LogSignal::reference))].text.most_decimals, 4);
  EXPECT_EQ(log.columns[static_cast<std::size_t>(*log.find(LogSignal::time))].text.most_decimals, 3);
}

TEST_F(JoinedLog, FaultsOfALongFileNameTheirLine) {
  const std::string head = "time [s],signal,value\n0,shoulder.counts,1\n";
  const std::vector<std::pair<std::string, std::string>> faults{
      {head + "1,shoulder.counts,x\n",
       "log.csv:3:19: shoulder.counts: not a finite decimal number, found 'x'"},
      {head + "1,shoulder.counts,\n", "log.csv:3:19: shoulder.counts: the cell is empty"},
      {head + "1,shoulder.counts,9007199254740994\n",
       "log.csv:3:1: shoulder.counts: counts beyond 2^53 are not distinguishable, found '9007199254740994'"},
      {head + "-1,shoulder.counts,2\n", "log.csv:3:1: time [s]: time must not decrease, after 0 s"},
      {head + "x,shoulder.counts,2\n", "log.csv:3:1: time [s]: not a finite decimal number, found 'x'"},
      {"signal,value\nshoulder.counts,1\n", "log.csv:1:1: rows of single signals need time stamps"},
      {"time [s],signal,value [deg]\n0,shoulder.counts,1\n",
       "log.csv:1:17: value [deg]: a unit of all signals"},
      {"time [s],signal,value,unit\n0,tip.x,1,m\n1,tip.x,1,mm\n",
       "log.csv:3:11: tip.x: a signal must have one unit"},
      {"time [s],signal,value,unit\n0,tip.x [m],1,m\n",
       "log.csv:2:3: tip.x [m]: the signal has a unit in its name"},
      {"time [s],signal,value\n", "log.csv:2:1: the log has no rows"}};
  for (const auto& [text, message] : faults)
    EXPECT_EQ(refusal(text).substr(0, message.size()), message) << text;
}

TEST_F(JoinedLog, FilesAreJoinedByTime) {
  const std::string counts = file("a.csv", "time [ms],shoulder.counts\n0,0\n2,2\n4,4\n6,6\n");
  const std::string truth =
      file("b.csv", "shoulder.reference [rad],time [s]\n0.1,0.001\n0.2,0.002\n0.5,0.005\n");
  const Log log = read_log(LogFiles({counts, truth}), spec);
  EXPECT_EQ(log.file, counts + ", " + truth);
  // Rows at the stamps of the counts; on a line, the cubic through the samples is this line.
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{0.002, 0.004}));
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{2, 4}));
  EXPECT_NEAR(column(log, LogSignal::reference)[0], 0.2, 1e-15);
  EXPECT_NEAR(column(log, LogSignal::reference)[1], 0.4, 1e-15);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_TRUE(has(log.warnings[0], "b.csv: interpolated at the stamps of the encoders; 2 rows left out"))
      << log.warnings[0];
  const Log swapped = read_log(LogFiles({truth, counts}), spec);
  EXPECT_EQ(column(swapped, LogSignal::reference), column(log, LogSignal::reference));
}

TEST_F(JoinedLog, AReferenceOfAnotherRateIsInterpolated) {
  const auto path = [](double t) { return 0.7 * std::sin(4 * t) + 0.2 * std::cos(11 * t); };
  std::string counts = "time [s],shoulder.counts,shoulder.effort [N m]\n",
              truth = "time [s],shoulder.reference [rad]\n",
              warm = "time [s],shoulder.temperature [degC]\n0.5,20\n1.5,30\n";
  for (int i = 0; i < 1000; ++i) counts += std::to_string(2e-3 * i) + ',' + std::to_string(i) + ",1\n";
  for (int i = 0; i < 660; ++i) {
    if (i > 300 && i < 320) continue;  // lost
    const double t = 1e-3 + 3e-3 * i;
    truth += std::to_string(t) + ',' + shortest(path(t)) + '\n';
  }
  const Log log =
      read_log(LogFiles({file("a.csv", counts), file("b.csv", truth), file("c.csv", warm)}), spec);
  const Doubles time = column(log, LogSignal::time), reference = column(log, LogSignal::reference),
                temperature = column(log, LogSignal::temperature);
  // 30 rows in the gap, one before the first sample, and those behind the last one at 1.978 s.
  EXPECT_EQ(log.rows, 1000u - 30 - 1 - 10);
  for (std::size_t k = 0; k < time.size(); ++k) {
    EXPECT_NEAR(reference[k], path(time[k]), 1e-7) << time[k];
    EXPECT_NEAR(temperature[k], temperature[0] + 10 * (std::clamp(time[k], 0.5, 1.5) - 0.5), 1e-9);
  }
}

/// Samples every 3 ms beside rows every 2 ms: the rows next to them.
TEST_F(JoinedLog, RowsNextToTheSamplesOfAReferenceAreKnown) {
  std::string counts = "time [s],shoulder.counts\n", truth = "time [s],shoulder.reference [rad]\n";
  for (int i = 0; i < 100; ++i) counts += std::to_string(2e-3 * i) + ",1\n";
  for (int i = 0; i < 20; ++i) truth += std::to_string(0.0065 + 7e-3 * i) + ",0.1\n";
  const Log log = read_log(LogFiles({file("a.csv", counts), file("b.csv", truth)}), spec);
  const Doubles time = column(log, LogSignal::time);
  const auto reference = static_cast<std::size_t>(*log.find(LogSignal::reference));
  const std::vector<Eigen::Index> rows = log.rows_at_samples(reference);
  ASSERT_EQ(rows.size(), 20U);
  for (std::size_t i = 1; i + 1 < rows.size(); ++i)
    EXPECT_LE(std::abs(time[static_cast<std::size_t>(rows[i])] - (0.0065 + 7e-3 * static_cast<double>(i))),
              1.0001e-3);
  EXPECT_TRUE(log.rows_at_samples(static_cast<std::size_t>(*log.find(LogSignal::counts))).empty());
}

/// The angles of poses are no samples of a motion: from row to row they may change by any part of a turn.
TEST_F(JoinedLog, PosesAreNotUnwrapped) {
  std::mt19937 dice(3);
  std::uniform_real_distribution<double> angle(-2.9, 2.9);
  std::string text = "time [s],shoulder.counts,shoulder.reference [rad]\n";
  std::vector<double> angles;
  const double step = spec.model.transmission.encoders[0].resolution;
  for (int i = 0; i < 60; ++i) {
    angles.push_back(angle(dice));
    text += std::to_string(4 * i) + ',' + std::to_string(std::llround(angles.back() / step)) + ',' +
            shortest(angles.back()) + '\n';
  }
  const Doubles reference = column(read_log(file("poses.csv", text), spec), LogSignal::reference);
  for (std::size_t k = 0; k < angles.size(); ++k) EXPECT_NEAR(reference[k], angles[k], 1e-12) << k;
}

TEST_F(JoinedLog, AReferenceOfAnotherRateMayWrap) {
  const auto path = [](double t) { return 2.5 + 3 * std::sin(1.5 * t); };
  std::string counts = "time [s],shoulder.counts\n";
  for (int i = 0; i < 4000; ++i) counts += std::to_string(2e-3 * i) + ",1\n";
  const std::string readings = file("a.csv", counts);
  for (const double lowest : {-std::numbers::pi, 0.0}) {
    std::string truth = "time [s],shoulder.reference [rad]\n";
    for (int i = 0; i < 2600; ++i) {
      const double t = 1e-3 + 3e-3 * i, turn = 2 * std::numbers::pi;
      truth +=
          std::to_string(t) + ',' + shortest(path(t) - turn * std::floor((path(t) - lowest) / turn)) + '\n';
    }
    const Log log = read_log(LogFiles({readings, file("b.csv", truth)}), spec);
    const Doubles time = column(log, LogSignal::time), reference = column(log, LogSignal::reference);
    EXPECT_GT(log.rows, 3880u);
    for (std::size_t k = 0; k < time.size(); ++k)
      ASSERT_NEAR(reference[k] - path(time[k]), reference[0] - path(time[0]), 1e-6) << time[k];
  }
}

TEST_F(JoinedLog, AReferenceThatStandsStillIsNotBent) {
  std::string counts = "time [s],shoulder.counts\n", truth = "time [s],shoulder.reference [rad]\n";
  for (int i = 0; i < 200; ++i) counts += std::to_string(2e-3 * i) + ",1\n";
  for (int i = 0; i < 100; ++i)
    truth += std::to_string(5e-3 * i) + ',' + shortest(0.1 * std::clamp(i, 30, 60)) + '\n';
  const Log log = read_log(LogFiles({file("a.csv", counts), file("b.csv", truth)}), spec);
  for (const double x : column(log, LogSignal::reference)) {
    EXPECT_GE(x, 3.0);
    EXPECT_LE(x, 6.0);
  }
}

TEST_F(JoinedLog, AWideAndALongFileJoin) {
  const std::string wide = file("a.csv", "time [s],shoulder.counts\n0,1\n1,2\n");
  const std::string tall = file(
      "b.csv", "time [s],signal,value\n0,shoulder.reference [rad],0.1\n1,shoulder.reference [rad],0.2\n");
  const Log log = read_log(LogFiles({wide, tall}), spec);
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{1, 2}));
  EXPECT_EQ(column(log, LogSignal::reference), (Doubles{0.1, 0.2}));
}

TEST_F(JoinedLog, AFileThatEndsEarlyIsReported) {
  std::string counts = "time [s],shoulder.counts\n";
  for (int i = 0; i < 9; ++i) counts += std::to_string(i) + ",5\n";
  const std::string a = file("a.csv", counts);
  const std::string b = file("b.csv", "time [s],shoulder.reference [rad]\n0,1\n1,1\n2,1\n");
  EXPECT_EQ(read_log(LogFiles({a, b}), spec).rows, 3u);
  spec.log.missing = MissingValues::hold;
  const Log log = read_log(LogFiles({a, b}), spec);
  EXPECT_EQ(log.rows, 9u);
  ASSERT_EQ(log.warnings.size(), 2u);
  EXPECT_TRUE(has(log.warnings[0], "b.csv: shoulder.reference [rad] ends 6 rows before the log does"));
}

TEST_F(JoinedLog, FaultsOfSeveralFilesNameTheFile) {
  const std::string a = file("a.csv", "time [s],shoulder.counts\n0,1\n1,2\n");
  const std::string twin = file("b.csv", "time [s],shoulder.counts\n0,1\n");
  const std::string table = file("c.csv", "shoulder.reference [rad]\n0.1\n");
  const std::string back = file("d.csv", "time [s],shoulder.reference [rad]\n1,0.1\n0,0.2\n");
  const std::string late = file("e.csv", "time [s],signal,value\n0,shoulder.reference [rad],x\n");
  const std::string twice = refused(LogFiles({a, twin}));
  EXPECT_TRUE(has(twice, "b.csv:1:10: shoulder.counts: duplicate column")) << twice;
  EXPECT_TRUE(has(twice, "a.csv")) << twice;
  EXPECT_TRUE(has(refused(LogFiles({a, table})), "c.csv:1:1: files are joined by time"));
  EXPECT_TRUE(has(refused(LogFiles({a, back})), "d.csv:3:1: time [s]: time must not decrease, after 1 s"));
  EXPECT_TRUE(has(refused(LogFiles({a, late})), "e.csv:2:28: shoulder.reference [rad]: not a finite"));
}

TEST_F(JoinedLog, AFaultyValueBeforeTheFirstRowNamesItsOwnLine) {
  const std::string a = file("a.csv", "time [s],shoulder.counts\n0,9007199254740994\n2,2\n");
  const std::string b = file("b.csv", "time [s],shoulder.reference [rad]\n1,0.1\n");
  EXPECT_TRUE(has(refused(LogFiles({a, b})), "no reading lies between two samples of the reference"));
  spec.log.missing = MissingValues::hold;
  EXPECT_TRUE(has(refused(LogFiles({a, b})), "a.csv:2:1: shoulder.counts: counts beyond 2^53"));
}

TEST_F(JoinedLog, EmptyCellsAreHeldOnlyOnRequest) {
  const std::string a = file("a.csv",
                             "time [s],shoulder.counts,shoulder.reference [rad],note\n0,1,,\n1,,0.25,x\n"
                             "2,3, ,\"y\"\n3,NaN,\"\",\n");
  const std::string without = refused(LogFiles(std::vector{a}));
  EXPECT_TRUE(has(without, "a.csv:2:5: shoulder.reference [rad]: the cell is empty")) << without;
  EXPECT_TRUE(has(without, "--set log.missing=drop")) << without;
  EXPECT_TRUE(has(without, "--hold")) << without;
  spec.log.missing = MissingValues::hold;
  const Log log = read_log(LogFiles(std::vector{a}), spec);
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{1, 2, 3}));
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{1, 3, 3}));
  EXPECT_EQ(column(log, LogSignal::reference), (Doubles{0.25, 0.25, 0.25}));
  EXPECT_EQ(log.row_number(0), 1u);
  EXPECT_EQ(log.columns[*log.find(LogSignal::reference)].held, 2u);
}

TEST_F(JoinedLog, RowsWithEmptyCellsAreLeftOutOnRequest) {
  const std::string a = file("a.csv",
                             "time [s],shoulder.counts,shoulder.reference [rad],note\n0,1,,\n1,2,0.25,\n,,,\n"
                             "3,,0.5,\n4,5,nan,\n5,6,0.75,\n");
  spec.log.missing = MissingValues::drop;
  const Log log = read_log(LogFiles(std::vector{a}), spec);
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{1, 5}));
  EXPECT_EQ(column(log, LogSignal::counts), (Doubles{2, 6}));
  EXPECT_EQ(column(log, LogSignal::reference), (Doubles{0.25, 0.75}));
  EXPECT_EQ(log.row_number(0), 1u);
  EXPECT_EQ(log.row_number(1), 5u);
  ASSERT_FALSE(log.warnings.empty());
  EXPECT_TRUE(
      has(log.warnings.back(),
          "4 of 6 rows left out, in which a signal has no value: time in 1 of 6 rows, shoulder.counts in 1 "
          "of 6 rows, shoulder.reference [rad] in 2 of 6 rows"))
      << log.warnings.back();
  const std::string b = file("b.csv", "time [s],shoulder.counts\n0,1\n1,2\n"),
                    c = file("c.csv", "time [s],shoulder.reference [rad]\n1,0.5\n2,0.5\n");
  EXPECT_EQ(column(read_log(LogFiles({b, c}), spec), LogSignal::time), (Doubles{1}));
  const std::string never = file("d.csv", "time [s],shoulder.counts,shoulder.reference [rad]\n0,1,\n1,,1\n");
  EXPECT_TRUE(has(refused(LogFiles(std::vector{never})), "no row in which every signal has a value"));
}

TEST_F(JoinedLog, ASignalThatNeverHasAValueIsAnError) {
  const std::string a = file("a.csv", "time [s],shoulder.counts,shoulder.reference [rad]\n0,1,\n1,2,\n");
  spec.log.missing = MissingValues::hold;
  EXPECT_TRUE(has(refused(LogFiles(std::vector{a})), "none of 'shoulder.reference [rad]'"));
}

// The rows of one log, written in three ways, in blocks that cut rows.
TEST_F(JoinedLog, WideLongAndSplitFilesAreOneLog) {
  std::string wide = "time [s],shoulder.counts,shoulder.reference [rad]\n", tall = "time [s],signal,value\n";
  std::string a = "time [s],shoulder.counts\n", b = "time [s],shoulder.reference [rad]\n";
  for (int i = 0; i < 5000; ++i) {
    const std::string t = std::to_string(i * 1e-3), n = std::to_string(i % 97),
                      r = std::to_string(i % 31 * 1e-3);
    wide += t + ',' + n + ',' + r + '\n';
    tall += t + ",shoulder.counts," + n + '\n' + t + ",shoulder.reference [rad]," + r + '\n';
    a += t + ',' + n + '\n';
    b += t + ',' + r + '\n';
  }
  const Eigen::ArrayXXd expected = read(wide).values;
  EXPECT_TRUE((read(tall).values == expected).all());
  EXPECT_TRUE((read(tall, {.block_bytes = 64, .block_rows = 100}).values == expected).all());
  const Log joined = read_log(LogFiles({file("a.csv", a), file("b.csv", b)}), spec);
  EXPECT_TRUE((joined.values == expected).all());
  EXPECT_TRUE(joined.warnings.empty());
}

struct Stamps {
  std::string unit, first, second, third;
  double second_time, third_time;  // after the first
};

// At 1.7e9 s a double resolves 240 ns: differences are taken before rounding.
TEST_F(JoinedLog, EpochStampsKeepEveryDigit) {
  const std::vector<Stamps> all{
      {"s", "1700000000.123456789", "1700000000.123456790", "1700000001.1", 1e-9, 0.976543211},
      {"ms", "1700000000123.456", "1700000000123.457", "1700000000124", 1e-6, 0.000544},
      {"us", "1700000000123456", "1700000000123457", "1700000000123556.5", 1e-6, 0.0001005},
      {"ns", "1700000000123456789", "1700000000123456790", "+1700000001123456790", 1e-9, 1.000000001},
      {"s", "2023-11-14T22:13:20.123456789Z", "2023-11-15 00:13:20.12345679+02:00", "1700000001.123456789",
       1e-9, 1}};
  for (const Stamps& s : all) {
    const Log log = read("time [" + s.unit + "],shoulder.counts\n" + s.first + ",1\n" + s.second + ",2\n" +
                         s.third + ",3\n");
    const Eigen::ArrayXd time = values(log, LogSignal::time);
    EXPECT_EQ(time[0], 0);
    EXPECT_NEAR(time[1], s.second_time, 1e-18) << s.first;
    EXPECT_NEAR(time[2], s.third_time, 1e-15) << s.first;
    EXPECT_NEAR(log.first_time, 1700000000.123456, 1e-6) << s.first;
    EXPECT_NEAR(log.last_time - log.first_time, s.third_time, 1e-6) << s.first;
    EXPECT_EQ(log.time_origin, log.first_time);
  }
}

TEST_F(JoinedLog, OrdinaryStampsKeepTheirZero) {
  const Log log = read("time [s],shoulder.counts\n8388607,1\n8388608.5,2\n");
  EXPECT_EQ(column(log, LogSignal::time), (Doubles{8388607, 8388608.5}));
  EXPECT_EQ(log.time_origin, 0);
}

TEST_F(JoinedLog, StampsOfSeveralFilesHaveOneOrigin) {
  const std::string a = file("a.csv", "time [s],shoulder.counts\n1700000000.5,1\n1700000001.5,2\n");
  const std::string b =
      file("b.csv", "time [ns],shoulder.reference [rad]\n1700000000500000000,1\n1700000001500000001,2\n");
  EXPECT_EQ(column(read_log(LogFiles({a, b}), spec), LogSignal::time), (Doubles{0, 1}));
  spec.log.missing = MissingValues::hold;
  EXPECT_EQ(column(read_log(LogFiles({a, b}), spec), LogSignal::time), (Doubles{0, 1, 1.000000001}));
}

TEST_F(JoinedLog, WrongDatesAreErrors) {
  for (const std::string stamp : {"2023-13-01T00:00:00Z", "2023-02-29T00:00:00Z", "2023-02-28",
                                  "2023-02-28T00:00:00.", "2023-02-28T00:00:00CET", "2023-02-28T00:61:00Z"})
    EXPECT_TRUE(has(refusal("time [s],shoulder.counts\n" + stamp + ",1\n"), "2:1: time [s]: not a")) << stamp;
}

}  // namespace
}  // namespace qerr
