#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>

namespace qerr::testing {

/// Values of the program itself, by name, in a CSV file of tests/golden with a first line of headings. They
/// prove nothing but that nothing changed: a deliberate change replaces them by the rows that a failure
/// prints.
class Measured {
 public:
  Measured(const std::string& file, double relative_tolerance) : tolerance_(relative_tolerance) {
    std::ifstream stream(QERR_SOURCE_DIR "/tests/golden/" + file);
    std::string line;
    std::getline(stream, line);
    while (std::getline(stream, line)) {
      const std::size_t comma = line.rfind(',');
      values_[line.substr(0, comma)] = std::stod(line.substr(comma + 1));
    }
  }

  /// @param tolerance  relative; in place of that of the file
  void expect(const std::string& name, double value, std::optional<double> tolerance = {}) const {
    std::ostringstream row;
    row.precision(9);
    row << name << ',' << value;
    met_.insert(name);
    const auto at = values_.find(name);
    ASSERT_NE(at, values_.end()) << "not measured: " << row.str();
    if (std::isfinite(at->second)) {
      EXPECT_NEAR(value, at->second, tolerance.value_or(tolerance_) * std::abs(at->second)) << row.str();
    } else {
      EXPECT_FALSE(std::isfinite(value)) << row.str();
    }
  }

  /// That every value whose name starts so has been expected: none is missing from what came out.
  void expect_all_met(const std::string& start) const {
    for (auto at = values_.lower_bound(start); at != values_.end() && at->first.starts_with(start); ++at)
      EXPECT_TRUE(met_.count(at->first)) << "no longer there: " << at->first;
  }

 private:
  double tolerance_;
  std::map<std::string, double> values_;
  mutable std::set<std::string> met_;
};

}  // namespace qerr::testing
