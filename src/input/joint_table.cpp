#include "input/joint_table.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/suggest.hpp"
#include "input/csv.hpp"
#include "input/joint_entries.hpp"
#include "qerr/core/unit.hpp"

namespace qerr {

namespace {

/// Opens a table. A file that is no CSV may be any file: messages do not show its content.
void open(std::optional<CsvReader>& table, const std::string& path) {
  try {
    table.emplace(path);
  } catch (const Error& e) {
    std::vector<Fault> faults = e.faults();
    for (Fault& fault : faults) fault.found.clear();
    throw Error(faults, e.trouble());
  }
}

/// A file without any column of the chain is some other file, too.
void require_columns(const CsvReader& table, const Chain& chain) {
  for (const std::string& cell : table.header())
    for (const std::string& name : joint_names(chain))
      if (column_name(cell).name == name) return;
  throw Error({table.header_place(0), "", "no column of the file is a joint of the chain", "",
               "give a CSV file with a header of the joints' names: " + list_of_names(joint_names(chain))});
}

/// The scale of a column from its unit to SI.
Unit column_unit(const std::string& cell, Dimension dimension, const Place& place) {
  const std::string unit = column_name(cell).unit;
  if (unit.empty()) return {};
  std::string why;
  const auto read = parse_unit(unit, why);
  if (!read || read->dimension != dimension)
    throw Error({place, cell, "the column has the wrong unit", "'" + unit + "'",
                 "use " + unit_name(dimension) + " or a unit of that kind"});
  return *read;
}

/// The index of a named column.
std::size_t find_column(const CsvReader& table, const std::string& name, const std::string& rule) {
  std::vector<std::string> names;
  for (const std::string& cell : table.header()) names.push_back(column_name(cell).name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw Error({table.header_place(0), name, rule, "", did_you_mean(name, names)});
  const auto second = std::find(found + 1, names.end(), name);
  if (second != names.end())
    throw Error({table.header_place(static_cast<std::size_t>(second - names.begin())), name,
                 "duplicate column", "", "keep one of them"});
  return static_cast<std::size_t>(found - names.begin());
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
  std::optional<CsvReader> opened;
  open(opened, path);
  CsvReader& table = *opened;
  require_columns(table, chain);
  std::vector<std::size_t> columns;
  std::vector<Unit> units;
  const auto choose = [&](const std::string& name, Dimension dimension, const std::string& rule) {
    const std::size_t i = columns.emplace_back(find_column(table, name, rule));
    units.push_back(column_unit(table.header()[i], dimension, table.header_place(i)));
  };
  const std::size_t has_time = with_time == TimeColumn::required;
  if (has_time) choose("time", dimension::time, "the file has no column for the time");
  for (const IndependentJoint& joint : chain.independent)
    choose(joint.name, coordinate_dimension(joint), "the file has no column for this joint");
  table.choose(columns);
  if (table.header().size() > columns.size())
    warnings.push_back(table.file() + ": columns that are not joints of the chain are ignored");

  JointTable result{table.file(), {}, {}, {}};
  std::vector<double> row(columns.size()), positions;
  while (table.next(row.data())) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = units[i].in_si(row[i]);
    if (has_time && !result.time.empty() && !(row[0] > result.time.back()))
      throw Error({table.place(0), "time", "time must increase from row to row",
                   shortest(row[0]) + " s after " + shortest(result.time.back()) + " s",
                   "sort the rows and keep one per instant"});
    if (has_time) result.time.push_back(row[0]);
    positions.insert(positions.end(), row.begin() + static_cast<std::ptrdiff_t>(has_time), row.end());
    result.lines.push_back(table.line());
  }
  if (result.lines.empty())
    throw Error(
        {{table.file(), table.line(), 1}, "", "the file has no rows of numbers", "", "give at least one"});
  result.positions =
      Eigen::Map<const Eigen::MatrixXd>(positions.data(), static_cast<Eigen::Index>(chain.independent.size()),
                                        static_cast<Eigen::Index>(result.lines.size()));
  return result;
}

}  // namespace qerr
