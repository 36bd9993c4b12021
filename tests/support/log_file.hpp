#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "qerr/core/error.hpp"
#include "qerr/input/read_log.hpp"

namespace qerr::testing {

/// A log of the corpus arm (revolute shoulder and elbow, a continuous wrist, a prismatic lift) in a temporary
/// folder.
class LogFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(test.begin(), test.end(), '/',
                 '_');  // of a parameter: no folder in a folder, which would stay
    folder = std::filesystem::temp_directory_path() / ("qerr_log_" + std::to_string(getpid()) + '_' + test);
    std::filesystem::create_directories(folder);
    spec = spec_with("'*': {counts_per_rev: 4096}, lift: {resolution: 10 um}");
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  Spec spec_with(const std::string& encoders, const std::string& more = "") {
    std::ofstream(folder / "spec.yaml")
        << "qerr: 1\nrobot: {urdf: '" QERR_SOURCE_DIR "/tests/corpus/arm.urdf'}\nencoders: {" << encoders
        << "}\nconfigurations: {count: 5, limits: {wrist: [-180 deg, 180 deg]}}\n"
        << more;
    return read_spec((folder / "spec.yaml").string());
  }

  std::string write(const std::string& text) {
    std::ofstream(folder / "log.csv", std::ios::binary) << text;
    return (folder / "log.csv").string();
  }

  Log read(const std::string& text) { return read_log(write(text), spec); }

  /// The complete log, read in blocks of a given size.
  Log read(const std::string& text, const LogOptions& options) {
    write(text);
    return reread(options);
  }

  /// The same for the file that was written last.
  Log reread(const LogOptions& options) {
    LogReader reader((folder / "log.csv").string(), spec, options);
    Eigen::ArrayXXd all(0, static_cast<Eigen::Index>(reader.log().columns.size()));
    for (Eigen::ArrayXXd rows; reader.next(rows);) {
      EXPECT_LE(rows.rows(), options.block_rows);
      all.conservativeResize(all.rows() + rows.rows(), Eigen::NoChange);
      all.bottomRows(rows.rows()) = rows;
    }
    Log log = reader.log();
    log.values = all;
    return log;
  }

  /// The error message of a log from its file's name on; "accepted" if the log is read.
  std::string refusal(const std::string& text, const LogOptions& options = {}) {
    write(text);
    return refused_again(options);
  }
  std::string refused_again(const LogOptions& options) {
    try {
      reread(options);
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::input);
      const std::string what = e.what();
      return what.substr(what.find("log.csv"));
    }
    return "accepted";
  }

  /// A column's values.
  static Eigen::ArrayXd values(const Log& log, LogSignal signal, std::size_t index = 0) {
    return log.values.col(log.find(signal, index).value());
  }

  std::filesystem::path folder;
  Spec spec;
};

}  // namespace qerr::testing
