#include <cmath>
#include <limits>

#include "qerr/core/quantity.hpp"
#include "support/log_file.hpp"

/// Logs in memory: each is read as the file of the same numbers.
namespace qerr::log_arrays_test {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

class LogArrays : public qerr::testing::LogFile {
 protected:
  /// Row by row, as a program keeps a matrix: neighbours of a column are three values apart.
  void set(std::vector<std::string> header, std::vector<double> all) {
    names = std::move(header), matrix = std::move(all);
  }
  LogFiles arrays() const {
    std::vector<LogArray> columns;
    for (std::size_t c = 0; c < names.size(); ++c)
      columns.push_back({names[c], matrix.data() + c, matrix.size() / names.size(),
                         static_cast<std::ptrdiff_t>(names.size())});
    return columns;
  }
  std::string table() const {
    std::string text;
    for (std::size_t c = 0; c < names.size(); ++c) text += (c ? "," : "") + names[c];
    for (std::size_t i = 0; i < matrix.size(); ++i)
      text += (i % names.size() ? "," : "\n") + (std::isnan(matrix[i]) ? "" : shortest(matrix[i]));
    return text + '\n';
  }
  std::string refused() {
    try {
      read_log(arrays(), spec);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }

  std::vector<std::string> names;
  std::vector<double> matrix;
};

TEST_F(LogArrays, AreTheFileOfTheSameNumbers) {
  for (const double origin : {0.0, 1748000000.25}) {
    std::vector<double> all;
    for (int i = 0; i < 500; ++i)
      all.insert(all.end(), {origin + i / 16.0, std::round(50 * std::sin(0.02 * i)), 0.0125 * i});
    set({"time [s]", "shoulder.counts", "shoulder.reference [deg]"}, all);
    const Log file = read(table()), log = read_log(arrays(), spec);
    ASSERT_EQ(log.rows, 500u);
    EXPECT_TRUE((log.values == file.values).all());
    EXPECT_EQ(log.time_origin, file.time_origin);
    for (std::size_t c = 0; c < log.columns.size(); ++c) {
      EXPECT_EQ(log.columns[c].header, file.columns[c].header);
      EXPECT_EQ(log.columns[c].text.most_decimals, file.columns[c].text.most_decimals)
          << log.columns[c].header;
      EXPECT_EQ(log.columns[c].text.least_decimals, file.columns[c].text.least_decimals);
    }
  }
}

TEST_F(LogArrays, MissingValuesAreDroppedHeldOrRefused) {
  set({"time [s]", "shoulder.counts", "shoulder.reference [rad]"}, {0, 1, 0, 1, 2, missing, 2, 3, 0.25});
  EXPECT_NE(refused().find("(arrays):2: shoulder.reference [rad]: the value is missing"), std::string::npos)
      << refused();
  spec.log.missing = MissingValues::drop;
  EXPECT_EQ(values(read_log(arrays(), spec), LogSignal::reference).sum(), 0.25);
  spec.log.missing = MissingValues::hold;
  EXPECT_EQ(read_log(arrays(), spec).rows, 3u);
}

TEST_F(LogArrays, AMistakeNamesColumnAndRow) {
  set({"time [s]", "shoulder.counts"}, {0, 1, 2, 1, 1, 1});
  EXPECT_NE(refused().find("(arrays):3: time [s]: time must not decrease, after 2 s"), std::string::npos)
      << refused();
  matrix[5] = std::numeric_limits<double>::infinity();
  matrix[4] = 3;
  EXPECT_NE(refused().find("(arrays):3: shoulder.counts: not a finite number"), std::string::npos)
      << refused();
  LogFiles uneven = arrays();
  uneven.arrays[1].rows = 2;
  EXPECT_THROW(read_log(uneven, spec), Error);
  names[1] = "q1 [deg]";
  EXPECT_NE(refused().find("has no measured joint"), std::string::npos) << refused();
}

}  // namespace
}  // namespace qerr::log_arrays_test
