#include "qerr/input/read_log.hpp"

#include <sys/stat.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <random>
#include <thread>

#include "qerr/report/simulation_report.hpp"
#include "support/log_file.hpp"

namespace qerr {
namespace {

using ReadLog = testing::LogFile;

const std::string joints = "shoulder.counts,shoulder.reference [rad]";

/// Shorthand for a header of time and a shoulder, and rows.
std::string shoulder(const std::string& rows) { return "time [s]," + joints + "\n" + rows; }

TEST_F(ReadLog, FindsColumnsByNameInAnyOrderAndConvertsThemToSi) {
  const Log log = read(
      "tip.y [mm],wrist.reference [deg],lift.measured [mm],time [ms],elbow.effort [mA],shoulder.counts "
      "[count],"
      "wrist.counts,lift.effort [N],lift.velocity [mm/s],elbow.command [mrad],shoulder.temperature [degC],"
      "elbow.counts,shoulder.effort [N m],wrist.effort [1],wrist.velocity [rpm]\n"
      "30,90,1.5,250,5,-7,3,40,2,7,21.5,9,0.5,0.25,60\n");
  ASSERT_EQ(log.rows, 1u);
  EXPECT_TRUE(log.warnings.empty()) << log.warnings[0];
  const auto value = [&](LogSignal signal, std::size_t i = 0) { return values(log, signal, i)[0]; };
  EXPECT_EQ(value(LogSignal::time), 0.25);
  EXPECT_EQ(value(LogSignal::tip, 1), 0.03);
  EXPECT_EQ(value(LogSignal::counts, 0), -7);
  EXPECT_EQ(value(LogSignal::counts, 1), 9);
  EXPECT_EQ(value(LogSignal::measured, 2), 1.5e-3);
  EXPECT_EQ(value(LogSignal::velocity, 2), 2e-3);
  EXPECT_EQ(value(LogSignal::reference, 3), 90 * (std::numbers::pi / 180));
  EXPECT_NEAR(value(LogSignal::velocity, 3), 2 * std::numbers::pi, 1e-15);
  EXPECT_EQ(value(LogSignal::command, 1), 7e-3);
  EXPECT_EQ(value(LogSignal::temperature), 21.5);
  EXPECT_EQ(value(LogSignal::effort, 1), 5e-3);
  const auto unit = [&](LogSignal signal, std::size_t i) {
    return log.columns[static_cast<std::size_t>(log.find(signal, i).value())].unit;
  };
  EXPECT_EQ(unit(LogSignal::effort, 0), "N m");
  EXPECT_EQ(unit(LogSignal::effort, 1), "A");
  EXPECT_EQ(unit(LogSignal::effort, 2), "N");
  EXPECT_EQ(unit(LogSignal::effort, 3), "1");
  EXPECT_EQ(unit(LogSignal::counts, 0), "count");
  EXPECT_EQ(unit(LogSignal::reference, 3), "rad");
}

TEST_F(ReadLog, CountsOfANegativeGearRatioRiseWithTheJoint) {
  spec = spec_with("'*': {counts_per_rev: 4096, gear_ratio: -100}, lift: {resolution: 10 um}");
  const Log log = read(shoulder("0,0,0\n1,-100,0.0015\n2,250,-0.0038\n"));
  EXPECT_EQ(values(log, LogSignal::counts, 0)[1], 100);
  EXPECT_EQ(values(log, LogSignal::counts, 0)[2], -250);
  // Reading = counts 2 pi / (counts per revolution * gear_ratio), the sign of the ratio included.
  const auto measured = measured_joint(log, log.values, spec.model.transmission, 0);
  EXPECT_NEAR((*measured)[1], -100 * 2 * std::numbers::pi / (4096 * -100), 1e-15);
}

TEST_F(ReadLog, CountsWrittenAsDecimalsAreCounts) {
  const Log log = read(shoulder("0,123.0,0\n1,-4.000,0\n"));
  EXPECT_EQ(values(log, LogSignal::counts)[1], -4);
  EXPECT_TRUE(log.warnings.empty());
}

TEST_F(ReadLog, CountsOnAFinerGridArePositions) {
  const double count = 2 * std::numbers::pi / 4096;
  const std::vector<std::pair<std::string, std::string>> grids{
      {"0,7,0\n1,7.5,0\n2,-8.25,0\n", "4"},
      {"0,7,0\n1,7.3333333333333339,0\n2,-8.25,0\n", "12"},
      {"0,7,0\n1,7.1,0\n2,-8.25,0\n", "20"},
      {"0,7,0\n1,7.333,0\n2,-8.25,0\n3,100000.667,0\n", "12"}};
  for (const auto& [rows, denominator] : grids) {
    const Log log = read(shoulder(rows));
    EXPECT_FALSE(log.find(LogSignal::counts));
    EXPECT_DOUBLE_EQ(values(log, LogSignal::measured)[2], -8.25 * count);
    ASSERT_EQ(log.warnings.size(), 1u);
    EXPECT_NE(log.warnings[0].find("multiples of 1/" + denominator + " count"), std::string::npos)
        << log.warnings[0];
  }
  spec = spec_with("'*': {counts_per_rev: 4096, gear_ratio: -100}, lift: {resolution: 10 um}");
  EXPECT_DOUBLE_EQ(values(read(shoulder("0,0.5,0\n")), LogSignal::measured)[0], -0.5 * count / 100);
}

TEST_F(ReadLog, IgnoresOtherColumnsWithAWarning) {
  const Log log =
      read("time [s],state,shoulder.counts,elbw.counts,\"a, b\"\n0,moving,1,x,\"1,2\"\n1,,2,,\"\"\"\n\"\n");
  EXPECT_EQ(log.rows, 2u);
  EXPECT_EQ(log.columns.size(), 2u);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("'state', 'elbw.counts' (did you mean 'elbow.counts'?), 'a, b'"),
            std::string::npos)
      << log.warnings[0];
}

TEST_F(ReadLog, WarnsWhereItAssumesSi) {
  const Log log = read("time,shoulder.counts,shoulder.reference,shoulder.effort\n0,1,2,3\n");
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("SI units: 'time', 'shoulder.reference'"), std::string::npos);
}

TEST_F(ReadLog, WithoutTimeItIsATable) {
  const Log log = read(joints + "\n1,0.5\n0,0.25\n");
  EXPECT_FALSE(log.has_time());
  EXPECT_EQ(log.rows, 2u);
}

/// One number in one of the usual formats.
std::string number_text(std::mt19937_64& dice) {
  const auto below = [&](int n) { return static_cast<int>(dice() % static_cast<unsigned>(n)); };
  double x = 0;
  switch (below(4)) {
    case 0:
      x = static_cast<double>(static_cast<std::int64_t>(dice()) >> below(64));
      break;
    case 1:
      do x = std::bit_cast<double>(dice());
      while (!std::isnormal(x) || std::abs(x) > 1e60);  // beyond any machine
      break;
    default:
      x = std::ldexp(static_cast<double>(static_cast<std::int64_t>(dice())), -63 + below(40) - 20);
  }
  char text[400];
  const char* const formats[] = {"%.*f", "%.*g", "%.*e", "%+.*f", "%0*.3f", " %.*f", "\"%.*f\"", "%.*E  "};
  const bool huge = std::abs(x) > 1e20;
  std::snprintf(text, sizeof text, formats[huge ? 1 + below(2) : below(8)], below(25), x);
  if (below(5) == 0) *std::to_chars(text, text + 40, x).ptr = '\0';
  return text;
}

/// strtod of a cell without quotes, independent of the reader.
double by_strtod(std::string cell) {
  std::erase(cell, '"');
  return std::strtod(cell.c_str(), nullptr);
}

class Tables : public ReadLog, public ::testing::WithParamInterface<int> {};

TEST_P(Tables, AreReadBitwiseAsByStrtod) {
  std::mt19937_64 dice(static_cast<unsigned>(GetParam()));
  std::string text = "note,shoulder.effort [1],shoulder.counts,elbow.effort [1],wrist.effort [1]\n";
  std::vector<std::array<double, 3>> expected;
  for (int row = 0; row < 60; ++row) {
    std::array<std::string, 3> cells;
    for (std::string& cell : cells) cell = number_text(dice);
    const std::array<double, 3> numbers{by_strtod(cells[0]), by_strtod(cells[1]), by_strtod(cells[2])};
    const bool sound = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (!sound) continue;
    expected.push_back(numbers);
    const char* const notes[] = {"", "ok", "\"a,b\"", "\"two\nlines\"", "\"\"\"\"", " 5"};
    text += std::string(notes[dice() % 6]) + ',' + cells[0] + ",7," + cells[1] + ',' + cells[2] +
            (dice() % 2 ? "\n" : "\r\n") + (dice() % 9 ? "" : "\n");
  }
  LogOptions options;
  options.block_bytes = 1 + dice() % 200;
  options.block_rows = static_cast<Eigen::Index>(1 + dice() % 20);
  const Log log = read(text, options);
  ASSERT_EQ(log.rows, expected.size());
  for (std::size_t row = 0; row < expected.size(); ++row)
    for (std::size_t i = 0; i < 3; ++i) {
      const double found = values(log, LogSignal::effort, i == 2 ? 3 : i)[static_cast<Eigen::Index>(row)];
      ASSERT_EQ(std::bit_cast<std::uint64_t>(found), std::bit_cast<std::uint64_t>(expected[row][i]))
          << found << " for " << expected[row][i];
    }
}

INSTANTIATE_TEST_SUITE_P(Random, Tables, ::testing::Range(0, 100));

TEST_F(ReadLog, IsIndependentOfTheBlockSize) {
  const std::string text =
      "\xEF\xBB\xBF# a comment, \"with an odd quote\r\n\r\n#\n\"time "
      "[s]\",note,shoulder.counts,shoulder.reference "
      "[rad]\r\n0.000,\"a \"\"b\"\",\nc\",1,-1.25e-3\r\n\n0.001, x ,-22 ,+.5\n0.002,\"\",\"333\", "
      "00.70000000000000000001\n"
      "0.0030,,4444,5.";
  const Log whole = read(text);
  ASSERT_EQ(whole.rows, 4u);
  EXPECT_EQ(values(whole, LogSignal::counts)[2], 333);
  EXPECT_EQ(values(whole, LogSignal::reference)[2], 0.7);
  for (std::size_t block = 1; block <= text.size() + 1; ++block) {
    const Log log = reread({.block_bytes = block, .block_rows = 3});
    ASSERT_EQ(log.rows, 4u) << block;
    ASSERT_TRUE((log.values == whole.values).all()) << block;
    for (std::size_t i = 0; i < log.columns.size(); ++i) {
      ASSERT_EQ(log.columns[i].text.most_decimals, whole.columns[i].text.most_decimals) << block;
      ASSERT_EQ(log.columns[i].text.least_decimals, whole.columns[i].text.least_decimals) << block;
      ASSERT_EQ(log.columns[i].text.most_digits, whole.columns[i].text.most_digits) << block;
    }
  }
}

TEST_F(ReadLog, DetectsTheFormatOfItsNumbers) {
  const Log log = read(
      "time [ms],shoulder.counts,shoulder.reference [mrad],shoulder.effort [1],shoulder.velocity [rad/s]\n"
      "0,-120,0.5000,21.06,1.2345e-05\n0.5,7,-12.2500,21,0\n1.25,0,0.0001,0.0003728,0.1234567890123456789\n");
  const auto text = [&](std::size_t i) { return log.columns[i].text; };
  EXPECT_EQ(text(0).most_decimals, 2);
  EXPECT_EQ(text(0).least_decimals, 0);
  EXPECT_DOUBLE_EQ(log.columns[0].step(), 1e-5);  // of milliseconds
  EXPECT_EQ(log.columns[1].step(), 1);
  EXPECT_EQ(text(2).most_decimals, 4);
  EXPECT_EQ(text(2).least_decimals, 4);
  EXPECT_EQ(text(2).most_digits, 6);
  EXPECT_DOUBLE_EQ(log.columns[2].step(), 1e-7);
  EXPECT_EQ(text(3).most_digits, 4);
  EXPECT_EQ(text(3).most_decimals, 7);
  EXPECT_EQ(text(4).most_decimals, 19);
  EXPECT_EQ(text(4).most_digits, 19);
}

TEST_F(ReadLog, ReadsTheLogOfSimulateBitwise) {
  for (const std::string effects : {"", "effects: [{type: log_rounding, joint: elbow, step: 0.1 mrad}]\n"}) {
    spec =
        spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}",
                  "filters: {velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, "
                  "order: 1, cutoff: 50 Hz}}}\n"
                  "motion: {sample_rate: 1 kHz, duration: 1 s, joints: {shoulder: {sines: [{amplitude: 1.1, "
                  "frequency: 1.3}]}, elbow: {velocity: 2}, lift: {center: 1 cm}, wrist: {velocity: -9}}}\n" +
                      effects);
    if (!effects.empty()) spec.model.chain.joints[1].load.mass = 2;
    LogWriter writer(spec);
    std::string text = writer.header();
    std::vector<Reading> readings;
    SimulationOptions options;
    options.visit = [&](const Reading& r) {
      text += writer.row(r);
      readings.push_back(r);
    };
    simulation_report(spec, options);
    const Log log = read(text);
    EXPECT_TRUE(log.warnings.empty());
    ASSERT_EQ(log.rows, readings.size());
    EXPECT_EQ(log.last_time, readings.back().time);
    const std::optional<Eigen::Index> rounded = log.find(LogSignal::measured, 1);
    EXPECT_EQ(rounded.has_value(), !effects.empty());
    for (Eigen::Index i = 0; i < log.values.rows(); ++i) {
      const Reading& r = readings[static_cast<std::size_t>(i)];
      ASSERT_EQ(values(log, LogSignal::time)[i], r.time);
      for (std::size_t j = 0; j < 4; ++j) {
        const auto row = static_cast<Eigen::Index>(j);
        ASSERT_EQ(values(log, LogSignal::reference, j)[i], r.reference[row]);
        EXPECT_EQ(log.find(LogSignal::effort, j).has_value(), !effects.empty());
        if (!effects.empty()) {
          ASSERT_EQ(values(log, LogSignal::effort, j)[i], r.effort[row]);
        }
        if (log.find(LogSignal::counts, j)) {
          ASSERT_EQ(values(log, LogSignal::counts, j)[i], r.counts[row]);
        }
      }
      if (rounded) {
        ASSERT_EQ(log.values(i, *rounded), r.logged[1]);
      }
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(values(log, LogSignal::tip, k)[i], r.tip.translation()[static_cast<Eigen::Index>(k)]);
    }
  }
}

TEST_F(ReadLog, AMeasuredJointIsTheCouplingOfItsEncodersCounts) {
  spec = spec_with("'*': {resolution: 1 mrad}, lift: {resolution: 10 um}",
                   "coupling: [[1, 0, 0, 0], [-0.5, 2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
  const Log log = read("time,shoulder.counts,elbow.counts,elbow.measured,wrist.measured\n0,10,3,7,5\n");
  const auto of = [&](std::size_t j) { return measured_joint(log, log.values, spec.model.transmission, j); };
  EXPECT_DOUBLE_EQ((*of(0))[0], 0.01);
  EXPECT_DOUBLE_EQ((*of(1))[0], -0.005 + 0.006);
  EXPECT_FALSE(of(2));
  EXPECT_EQ((*of(3))[0], 5);
  EXPECT_NE(refusal("time [s],elbow.counts,elbow.reference [rad]\n0,1,2\n").find("coupled"),
            std::string::npos);
}

TEST_F(ReadLog, ReadsAPipe) {
  const std::string path = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream out(path);
    out << shoulder("");
    for (int i = 0; i < 30000; ++i) out << i << ',' << -i << ",0.5\n";
  });
  const Log log = read_log(path, spec);
  writer.join();
  EXPECT_EQ(log.rows, 30000u);
  EXPECT_EQ(values(log, LogSignal::counts).sum(), -30000.0 * 29999 / 2);
}

TEST_F(ReadLog, KeepsALongLogAsBlocksSpreadOverIt) {
  std::string text = shoulder("");
  constexpr int rows = 300000;
  for (int i = 0; i < rows; ++i) text += std::to_string(i) + ',' + std::to_string(2 * i) + ",0.5\n";
  const Log all = read_log(write(text), spec), few = read_log((folder / "log.csv").string(), spec, 200000);
  EXPECT_EQ(all.values.rows(), rows);
  EXPECT_TRUE(all.stretches.empty());
  EXPECT_EQ(few.rows, static_cast<std::uint64_t>(rows));
  EXPECT_LE(few.values.size(), 200000);
  EXPECT_GE(few.values.size(), 90000);
  ASSERT_EQ(few.warnings.size(), 1u);
  const Eigen::ArrayXd time = values(few, LogSignal::time);
  for (Eigen::Index k = 0; k < time.size(); ++k)
    ASSERT_EQ(time[k], static_cast<double>(few.row_number(k))) << "its rows are those of the file, row " << k;
  EXPECT_GT(time.maxCoeff(), 0.7 * rows);
}

TEST_F(ReadLog, AcceptsOrRejectsRandomBytes) {
  std::mt19937_64 dice(5);
  const std::string sound = shoulder("0.000,1,0.5\n\"0.001\",-2,1e-3\r\n0.002,3,.25\n");
  const std::string spice = "\",\n\r#+-.eE0\xEF\xBB\xBF \t[";
  int accepted = 0;
  for (int i = 0; i < 800; ++i) {
    std::string text = i % 10 ? sound : "";
    for (std::size_t k = 0; k < 40 && text.size() < 40; ++k) text += static_cast<char>(dice());
    for (std::size_t k = dice() % 6; k > 0; --k) {
      const std::size_t at = dice() % text.size();
      const char c = dice() % 3 ? spice[dice() % spice.size()] : static_cast<char>(dice());
      if (dice() % 2)
        text[at] = c;
      else
        text.insert(at, 1, c);
    }
    if (dice() % 4 == 0) text.resize(dice() % text.size());
    const std::string by_blocks = refusal(text, {.block_bytes = 1 + dice() % 30, .block_rows = 10});
    ASSERT_EQ(by_blocks, refused_again({.block_bytes = 4096, .block_rows = 10})) << text;
    accepted += by_blocks == "accepted";
  }
  EXPECT_GT(accepted, 80);
  EXPECT_LT(accepted, 600);
}

TEST_F(ReadLog, ReadsTheSharedExamples) {
  const std::filesystem::path shared = std::filesystem::path(QERR_SOURCE_DIR) / ".." / "shared";
  std::size_t logs = 0;
  for (const char* const name : {"hidden_examples", "data"}) {
    if (!std::filesystem::exists(shared / name)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(shared / name)) {
      if (entry.path().extension() != ".csv") continue;
      const Spec of_example = read_spec((entry.path().parent_path() / "spec.yaml").string());
      const Log log = read_log(entry.path().string(), of_example);
      ++logs;
      EXPECT_GT(log.rows, 100u) << entry.path();
      EXPECT_TRUE(log.warnings.empty()) << entry.path() << ": " << log.warnings[0];
      for (const LogColumn& column : log.columns) {
        EXPECT_EQ(column.wraps.count, 0u) << column.header;
        EXPECT_EQ(column.wraps.start, 0) << column.header;
      }
    }
  }
  if (logs == 0) GTEST_SKIP() << "no logs in " << shared;
}

}  // namespace
}  // namespace qerr
