#include "fuzz/table_mutation.hpp"

#include <cmath>
#include <iterator>
#include <random>
#include <utility>
#include <vector>

#include "qerr/core/quantity.hpp"

namespace qerr::fuzz {

namespace {

using Row = std::vector<std::string>;

/// Cells at the edges of number formats and of physics, and some that are no numbers.
const char* const hostile[] = {"",        "0",      "-0.0",        "1",       "-1",       "0.5",
                               "1e-320",  "1e300",  "-1e9",        "1e13",    "1.8e308",  "9007199254740993",
                               "nan",     "-inf",   "0x10",        " 7 ",     "1 m",      "\"1\"",
                               "\"1,2\"", "=1+1",   "1;2",         "1_000",   "\x1b[31m", "2147483648",
                               "true",    "-65536", "6.283185307", "time [s]"};
const char* const headings[] = {"time [ms]",
                                "time",
                                "tip.x [m]",
                                "tip.y [mm]",
                                "tip.z [m]",
                                "shoulder.counts",
                                "shoulder.reference [deg]",
                                "shoulder.measured [rad]",
                                "shoulder.effort [N m]",
                                "shoulder.temperature [K]",
                                "elbow.counts",
                                "elbow.reference [rad]",
                                "wrist.counts",
                                "signal",
                                ""};

/// At least one part.
std::vector<std::string> parts(const std::string& text, char separator) {
  std::vector<std::string> found(1);
  for (const char c : text)
    if (c == separator)
      found.emplace_back();
    else
      found.back() += c;
  return found;
}

class TableChange {
 public:
  TableChange(std::vector<Row>& rows, unsigned seed) : rows_(rows), random_(seed) {}

  void make() {
    const std::size_t column = index(rows_[0].size()), row = 1 + index(rows_.size() - 1);
    switch (index(11)) {
      case 0:
        if (column < rows_[row].size()) rows_[row][column] = hostile[index(std::size(hostile))];
        break;
      case 1:
        rows_[0][column] = headings[index(std::size(headings))];
        break;
      case 2:
        scale(column, std::pow(10., std::uniform_int_distribution<int>(-20, 20)(random_)));
        break;
      case 3:
        scale(column, one_in(2) ? -1 : 1e-6 * static_cast<double>(random_() % 4000000));
        break;
      case 4:
        for (std::size_t i = row; i < rows_.size() && column < rows_[i].size(); ++i)
          rows_[i][column] = rows_[row][column];
        break;
      case 5:
        swap(column, index(rows_[0].size()));
        break;
      case 6:
        rows_.erase(rows_.begin() + static_cast<long>(row),
                    rows_.begin() + static_cast<long>(row + index(rows_.size() - row)));
        break;
      case 7:
        std::swap(rows_[row], rows_[1 + index(rows_.size() - 1)]);
        break;
      case 8: {  // another origin, far or near
        const double shift = std::pow(10., std::uniform_int_distribution<int>(0, 16)(random_));
        each_number(column, [&](double value) { return value + shift; });
        break;
      }
      case 9: {  // the lowest bits of a counter
        const double end = std::pow(2., std::uniform_int_distribution<int>(1, 12)(random_));
        each_number(column, [&](double value) { return value - end * std::floor(value / end); });
        break;
      }
      default:
        add(column, std::pow(10., std::uniform_int_distribution<int>(-6, 6)(random_)));
    }
  }

 private:
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  bool one_in(unsigned count) { return random_() % count == 0; }

  template <class Change>
  void each_number(std::size_t column, const Change& change) {
    for (std::size_t i = 1; i < rows_.size(); ++i)
      if (column < rows_[i].size())
        if (const auto value = parse_number(rows_[i][column])) rows_[i][column] = shortest(change(*value));
  }
  void scale(std::size_t column, double factor) {
    each_number(column, [&](double value) { return factor * value; });
  }
  /// Noise, or jumps in some rows.
  void add(std::size_t column, double size) {
    const bool jumps = one_in(2);
    std::normal_distribution<double> noise(0, size);
    each_number(column, [&](double value) { return jumps && !one_in(20) ? value : value + noise(random_); });
  }
  void swap(std::size_t one, std::size_t other) {
    for (Row& r : rows_)
      if (one < r.size() && other < r.size()) std::swap(r[one], r[other]);
  }

  std::vector<Row>& rows_;
  std::mt19937 random_;
};

}  // namespace

std::string changed_table(const std::string& text, unsigned seed) {
  std::vector<Row> rows;
  for (const std::string& line : parts(text, '\n')) rows.push_back(parts(line, ','));
  if (rows.size() < 2) return "";
  TableChange(rows, seed).make();
  std::string changed;
  for (const Row& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) changed += row[i] + (i + 1 < row.size() ? ',' : '\n');
  changed.pop_back();
  return changed;
}

}  // namespace qerr::fuzz
