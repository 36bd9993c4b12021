#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/log_columns.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Opens a table. A file that is none may be any file: messages do not show its content.
LogTable opened_table(const std::string& path, const LogReading& reading) {
  try {
    return {path, reading, {}};
  } catch (const Error& e) {
    std::vector<Fault> faults = e.faults();
    for (Fault& fault : faults) fault.found.clear();
    throw Error(faults, e.trouble());
  }
}

/// How surely a column has the positions of a joint: called like it, or its signal in a log, the truth
/// first, or a JointState's; empty if it has not.
std::optional<std::size_t> rank_of(const LogHeader& column, const std::string& joint) {
  const std::string name = column_name(column.text).name;
  const std::string names[] = {joint, joint + ".reference", joint + ".measured", joint + ".command"};
  for (std::size_t rank = 0; rank < std::size(names); ++rank)
    if (name == names[rank] || column.meaning.signal == names[rank]) return rank;
  return name.ends_with('/' + joint + "/position") ? std::optional(std::size(names)) : std::nullopt;
}

std::size_t find_column(const LogTable& table, const std::string& joint) {
  std::vector<std::string> names;
  std::vector<std::size_t> best;
  std::size_t best_rank = std::string::npos;
  for (std::size_t i = 0; i < table.header().size(); ++i) {
    names.push_back(column_name(table.header()[i].text).name);
    const auto rank = rank_of(table.header()[i], joint);
    if (!rank || *rank > best_rank) continue;
    if (*rank < best_rank) best.clear();
    best_rank = *rank;
    best.push_back(i);
  }
  if (best.empty())
    throw Error(table.header()[0].place, joint, "the file has no column for this joint", "",
                did_you_mean(joint, names) + "; log: {columns: {" + joint + ".reference: COLUMN}} maps it");
  if (best.size() > 1)
    throw Error(table.header()[best[1]].place, joint, "duplicate column", "", "keep one of them");
  return best.front();
}

/// A file without any column of the chain is some other file, too.
void require_columns(const LogTable& table, const Chain& chain) {
  for (const LogHeader& column : table.header())
    for (const std::string& name : joint_names(chain))
      if (rank_of(column, name)) return;
  throw Error(table.header()[0].place, "", "no column of the file is a joint of the chain", "",
              "give a file with a header of the joints' names: " + list_of_names(joint_names(chain)) +
                  ", or map its columns, as with log: {columns: {" + joint_names(chain)[0] +
                  ".reference: COLUMN}}");
}

/// The scale of a column from its unit to SI.
Unit column_unit(const LogHeader& column, const std::string& joint, Dimension dimension) {
  const ColumnName cell = column_name(column.text);
  // A joint may be called `wrist_deg`.
  const bool plain = cell.name == joint && !column.meaning.mapped;
  const std::string words = unit_in_words(cell.unit);
  const std::string unit = !plain ? column.meaning.unit : words.empty() ? cell.unit : words;
  if (unit.empty()) return {};
  std::string why;
  const auto read = parse_unit(unit, why);
  if (!read || read->dimension != dimension)
    throw Error(column.place, column.text, "the column has the wrong unit", "'" + unit + "'",
                "use " + unit_name(dimension) + " or a unit of that kind");
  return *read;
}

/// Columns of efforts and temperatures of the joints; their places are added to the others.
std::vector<LogColumn> load_columns(const LogTable& table, const Chain& chain,
                                    std::vector<std::size_t>& places) {
  std::vector<LogColumn> loads;
  for (std::size_t i = 0; i < table.header().size(); ++i)
    for (std::size_t j = 0; j < chain.independent.size(); ++j)
      for (const LogSignal signal : {LogSignal::effort, LogSignal::temperature}) {
        const LogHeader& header = table.header()[i];
        const std::string_view name = signal == LogSignal::effort ? ".effort" : ".temperature";
        if (header.meaning.signal != chain.independent[j].name + std::string(name)) continue;
        loads.push_back(column_of(header, signal, j, chain));
        places.push_back(i);
      }
  return loads;
}

}  // namespace

bool inside(double value, const Limits& limits) {
  const double slack = 1e-9 * std::max(1.0, std::abs(value));
  return value >= limits.lower - slack && value <= limits.upper + slack;
}

std::string text_of(const Limits& l, const IndependentJoint& joint) {
  return "[" + shortest(l.lower) + ", " + shortest(l.upper) + "] " + unit_name(coordinate_dimension(joint));
}

JointTable read_joint_table(const std::string& path, const Spec& spec, TimeColumn with_time,
                            std::vector<std::string>& warnings) {
  const Chain& chain = spec.model.chain;
  LogTable table = opened_table(path, spec.log);
  require_columns(table, chain);
  std::vector<std::size_t> columns;
  std::vector<Unit> units;
  const std::size_t has_time = with_time == TimeColumn::required;
  if (has_time) {
    const auto time = std::find_if(table.header().begin(), table.header().end(),
                                   [](const LogHeader& h) { return h.meaning.signal == "time"; });
    if (time == table.header().end())
      throw Error(table.header()[0].place, "time", "the file has no column for the time", "",
                  "add a column 'time [s]', or say which it is: log: {time: COLUMN}");
    columns.push_back(static_cast<std::size_t>(time - table.header().begin()));
  }
  for (const IndependentJoint& joint : chain.independent) {
    columns.push_back(find_column(table, joint.name));
    units.push_back(column_unit(table.header()[columns.back()], joint.name, coordinate_dimension(joint)));
  }
  const std::vector<LogColumn> loads =
      has_time ? load_columns(table, chain, columns) : std::vector<LogColumn>{};
  table.choose(columns, std::vector(columns.size(), Joining::held));
  if (table.header().size() > columns.size())
    warnings.push_back(table.file() + ": columns that are not joints of the chain are ignored");

  JointTable result{table.file(), {}, {}, {}, {}, {}};
  std::vector<double> row(columns.size()), positions, load_values;
  while (table.next(row.data(), 1)) {
    if (has_time && !result.time.empty() && !(row[0] > result.time.back()))
      throw Error(table.last_line(), "time", "time must increase from row to row",
                  shortest(row[0]) + " s after " + shortest(result.time.back()) + " s",
                  "sort the rows and keep one per instant");
    if (has_time) result.time.push_back(row[0]);
    for (std::size_t i = 0; i < units.size(); ++i) positions.push_back(units[i].in_si(row[has_time + i]));
    for (std::size_t i = 0; i < loads.size(); ++i)
      load_values.push_back(loads[i].scale.in_si(row[has_time + units.size() + i]));
    result.lines.push_back(table.last_line().line);
  }
  for (std::string& warning : table.warnings()) warnings.push_back(std::move(warning));
  for (std::size_t i = 0; i < units.size(); ++i) {
    constexpr double farthest = 4 * std::numbers::pi;
    const bool bare = units[i].dimension == Dimension{} && !chain.independent[i].prismatic();
    double most = 0;
    for (std::size_t k = i; k < positions.size(); k += units.size())
      most = std::max(most, std::abs(positions[k]));
    if (bare && most > farthest)
      warnings.push_back(table.file() + ": '" + chain.independent[i].name + "' is read in rad, up to " +
                         significant(most, 3) + ": write its unit behind the name, such as [deg]");
  }
  if (result.lines.empty())
    throw Error(table.last_line(), "", "the file has no rows of numbers", "", "give at least one");
  result.positions =
      Eigen::Map<const Eigen::MatrixXd>(positions.data(), static_cast<Eigen::Index>(chain.independent.size()),
                                        static_cast<Eigen::Index>(result.lines.size()));
  for (auto* signals : {&result.efforts, &result.temperatures}) signals->resize(chain.independent.size());
  const Eigen::Map<const Eigen::MatrixXd> by_row(load_values.data(), static_cast<Eigen::Index>(loads.size()),
                                                 static_cast<Eigen::Index>(result.lines.size()));
  for (std::size_t i = 0; i < loads.size(); ++i)
    (loads[i].signal == LogSignal::effort ? result.efforts : result.temperatures)[loads[i].index] = {
        loads[i].unit, by_row.row(static_cast<Eigen::Index>(i))};
  return result;
}

}  // namespace qerr
