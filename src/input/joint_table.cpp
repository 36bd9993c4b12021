#include "joint_table.hpp"

#include <algorithm>
#include <cmath>

#include "csv.hpp"
#include "qerr/core/suggest.hpp"

namespace qerr {

namespace {

/// The factor from a column's unit to SI.
double column_factor(const std::string& cell, Dimension dimension, const Place& place) {
  const std::string unit = column_name(cell).unit;
  if (unit.empty()) return 1;
  std::string why;
  const auto quantity = parse_quantity("1 " + unit, why);
  if (!quantity || quantity->dimension != dimension)
    throw Error({place, cell, "the column has the wrong unit", "'" + unit + "'",
                 "use " + unit_name(dimension) + " or a unit of that kind"});
  return quantity->value;
}

/// A named column of numbers, in SI units.
std::vector<double> column(const CsvTable& table, const std::string& path, const std::string& name,
                           Dimension dimension, const std::string& rule) {
  const Place header{path, 1, 1};
  std::vector<std::string> names;
  for (const std::string& cell : table.header) names.push_back(column_name(cell).name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw Error({header, name, rule, "", did_you_mean(name, names)});
  if (std::count(names.begin(), names.end(), name) > 1)
    throw Error({header, name, "two columns have this name", "", "keep one of them"});
  const auto i = static_cast<std::size_t>(found - names.begin());
  const double factor = column_factor(table.header[i], dimension, header);
  std::vector<double> values;
  for (const std::vector<double>& row : table.rows) values.push_back(factor * row[i]);
  return values;
}

void check_increasing(const JointTable& t) {
  for (std::size_t i = 1; i < t.time.size(); ++i)
    if (!(t.time[i] > t.time[i - 1]))
      throw Error({{t.path, t.lines[i], 1},
                   "time",
                   "time must increase from row to row",
                   shortest(t.time[i]) + " s after " + shortest(t.time[i - 1]) + " s",
                   "sort the rows, keep one per instant"});
}

}  // namespace

bool inside(double value, const Limits& limits) {
  const double slack = 1e-9 * std::max(1.0, std::abs(value));
  return value >= limits.lower - slack && value <= limits.upper + slack;
}

std::string text_of(const Limits& l, const IndependentJoint& joint) {
  return "[" + shortest(l.lower) + ", " + shortest(l.upper) + "] " + unit_name(coordinate_dimension(joint));
}

JointTable read_joint_table(const std::string& path, const Chain& chain, TimeColumn with_time,
                            std::vector<std::string>& warnings) {
  const CsvTable table = read_csv_table(path);
  JointTable result{path, {}, {}, table.lines};
  if (with_time == TimeColumn::required) {
    result.time = column(table, path, "time", dimension::time, "the file has no column for the time");
    check_increasing(result);
  }
  const auto n = static_cast<Eigen::Index>(chain.independent.size());
  const auto rows = static_cast<Eigen::Index>(table.rows.size());
  result.positions.resize(n, rows);
  for (Eigen::Index j = 0; j < n; ++j) {
    const IndependentJoint& joint = chain.independent[static_cast<std::size_t>(j)];
    const std::vector<double> values =
        column(table, path, joint.name, coordinate_dimension(joint), "the file has no column for this joint");
    result.positions.row(j) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), rows);
  }
  const std::size_t used = chain.independent.size() + (with_time == TimeColumn::required);
  if (table.header.size() > used)
    warnings.push_back(path + ": columns that are no joint of the chain are ignored");
  return result;
}

}  // namespace qerr
