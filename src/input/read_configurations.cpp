#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double most_grid_points = 1e12;
constexpr std::size_t most_named = 6;  // joints in a warning

Limits read_limits(const Field& f, const IndependentJoint& joint) {
  const std::string example = joint.prismatic() ? "[0, 300 mm]" : "[-90 deg, 90 deg]";
  const std::vector<Field> ends = read_list(f, "[lower, upper], such as " + example);
  if (ends.size() != 2)
    f.refuse("limits must be two numbers", ends.size() == 4
                                               ? "write " + example + ", with a decimal point in a number"
                                               : "write [lower, upper], such as " + example);
  const Parameter row{.name = "limits", .coordinate = true};
  const Limits limits{read_number(ends[0], row, coordinate_dimension(joint)),
                      read_number(ends[1], row, coordinate_dimension(joint))};
  if (limits.lower > limits.upper)
    throw Error(f.node->place, f.path, "the lower limit is above the upper one", text_of(limits, joint),
                "swap them");
  // An empty range is what exporters write for limits that nobody entered.
  const bool narrows = joint.limits && joint.limits->lower < joint.limits->upper;
  if (narrows && (!inside(limits.lower, *joint.limits) || !inside(limits.upper, *joint.limits)))
    throw Error(f.node->place, f.path, "the limits exceed those of the URDF", text_of(limits, joint),
                "stay within " + text_of(*joint.limits, joint) +
                    (joint.prismatic() ? "" : "; degrees need their unit, such as " + example));
  return limits;
}

/// The fault of a joint that has limits neither in the URDF nor in the spec.
Fault no_limits(const RobotModel& robot, const IndependentJoint& joint) {
  const std::string in_spec = "configurations: {limits: {" + joint.name + ": " +
                              (joint.prismatic() ? "[0, 500 mm]" : "[-180 deg, 180 deg]") + "}}";
  return {find_named(robot.joints, joint.name)->place, "joint '" + joint.name + "'",
          std::string("the ") + (joint.prismatic() ? "prismatic" : "revolute") +
              " joint has no limits in the URDF",
          "", "add lower and upper to its <limit>, or its range to the spec, such as " + in_spec};
}

/// Warns of joints that do not move: exporters write [0, 0] for limits that nobody entered.
void warn_of_empty_ranges(const Chain& chain, const std::vector<Limits>& ranges,
                          std::vector<std::string>& warnings) {
  std::string held;
  std::size_t count = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].lower != ranges[i].upper) continue;
    if (++count <= most_named)
      held += (held.empty() ? "'" : ", '") + chain.independent[i].name + "' at " + shortest(ranges[i].lower);
  }
  if (count > most_named) held += " and " + std::to_string(count - most_named) + " more";
  if (count == 0) return;
  const std::string remedy =
      "; exporters write 0 for limits that nobody entered: correct <limit>, or give configurations.limits";
  warnings.push_back(
      count == ranges.size()
          ? "the range of every joint is empty, so that a single configuration is analyzed and "
            "the figures say nothing about the rest of the workspace: " +
                held + remedy
          : counted(count, "joint") + " with an empty range, held in place: " + held + remedy);
}

/// The limits in the spec. A joint with faulty ones has no others: they are not reported as missing.
std::vector<std::optional<Limits>> given_limits(const Object& o, const RobotModel& robot, Spec& spec,
                                                Faults& faults) {
  const Chain& chain = spec.model.chain;
  std::vector<std::optional<Limits>> given(chain.independent.size());
  if (!o.has("limits")) return given;
  const std::vector<JointEntry> entries = joint_entries(o.at("limits"), robot, spec, faults);
  EntryFaults of_entries;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!entries[i].given()) continue;
    given[i] = Limits{};
    of_entries.guard(chain.independent[i], entries[i].holding(), [&] {
      given[i] = read_limits(entries[i].holding(), chain.independent[i]);
      if (chain.independent[i].prismatic()) return;
      for (const Field& end : read_list(entries[i].holding())) warn_of_degrees(end, 4, spec.warnings);
    });
  }
  faults.guard([&] { of_entries.raise(); });
  return given;
}

/// A turn has all positions of a continuous joint.
void warn_of_whole_turns(const std::vector<std::string>& joints, std::vector<std::string>& warnings) {
  if (joints.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < std::min(joints.size(), most_named); ++i)
    names += (i > 0 ? ", '" : "'") + joints[i] + "'";
  if (joints.size() > most_named) names += " and " + std::to_string(joints.size() - most_named) + " more";
  warnings.push_back("continuous joints without limits, " + names +
                     ": a whole turn is sampled, -180 to 180 deg; configurations: {limits: {" +
                     joints.front() + ": [-90 deg, 90 deg]}} narrows it");
}

/// The range of every joint: the limits of the spec, else of the URDF. A continuous joint without limits is
/// unbounded where the configurations are given as points, and has a whole turn otherwise.
std::vector<Limits> read_ranges(const Object& o, const RobotModel& robot, Spec& spec, Faults& faults) {
  const bool given_points = o.has("points") || o.has("file");
  const Chain& chain = spec.model.chain;
  const std::vector<std::optional<Limits>> given = given_limits(o, robot, spec, faults);
  std::vector<Limits> ranges(chain.independent.size());
  std::vector<std::string> whole_turns;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const IndependentJoint& joint = chain.independent[i];
    if (given[i]) {
      ranges[i] = *given[i];
    } else if (joint.type == JointType::continuous && given_points) {
      ranges[i] = {-infinity, infinity};
    } else if (joint.limits) {
      ranges[i] = *joint.limits;
    } else if (joint.type == JointType::continuous) {
      ranges[i] = {-std::numbers::pi, std::numbers::pi};
      whole_turns.push_back(joint.name);
    } else {
      faults.guard([&] { throw Error(no_limits(robot, joint)); });
    }
  }
  warn_of_whole_turns(whole_turns, spec.warnings);
  if (!given_points && !faults.any()) warn_of_empty_ranges(chain, ranges, spec.warnings);
  return ranges;
}

void check_point(double value, std::size_t joint, const Spec& spec, const Field* field, const Place& place,
                 const std::string& path) {
  const IndependentJoint& j = spec.model.chain.independent[joint];
  if (inside(value, spec.configurations.ranges[joint])) return;
  throw Error(field ? field->node->place : place, path,
              "joint '" + j.name + "' is outside its limits " + text_of(spec.configurations.ranges[joint], j),
              field ? described(*field->node) : shortest(value),
              "give a value within them; degrees need their unit: '90 deg'");
}

void read_points(const Object& o, Spec& spec) {
  if (!o.has("points")) o.self().refuse_missing("points", "add 'points: [[...], ...]'");
  const auto n = spec.model.chain.independent.size();
  const Field points = o.at("points");
  for (const Field& point : read_list(points, "[[0, 0.1], [0.2, 0.3]]")) {
    const std::vector<Field> values = read_list(point);
    if (values.size() != n)
      point.refuse("a point must have one value per joint: " + std::to_string(n),
                   "give them in the order " + did_you_mean("", joint_names(spec.model.chain)).substr(7));
    Eigen::VectorXd q(n);
    for (std::size_t j = 0; j < n; ++j) {
      q[j] = read_number(values[j], {.name = "points", .coordinate = true},
                         coordinate_dimension(spec.model.chain.independent[j]));
      check_point(q[j], j, spec, &values[j], {}, values[j].path);
    }
    spec.configurations.points.push_back(q);
  }
  if (spec.configurations.points.empty()) points.refuse("the list is empty", "give at least one point");
}

void read_point_file(const Object& o, const std::string& folder, Spec& spec) {
  const auto name = o.text("file");
  if (!name) o.self().refuse_missing("file", "add 'file: points.csv'");
  spec.points_file = (std::filesystem::path(folder) / *name).string();
  JointTable table;
  read_named_file(o.at("file"), spec.points_file, [&](const std::string& path) {
    table = read_joint_table(path, spec, TimeColumn::none, spec.warnings);
  });
  for (Eigen::Index i = 0; i < table.positions.cols(); ++i) {
    const Eigen::VectorXd q = table.positions.col(i);
    for (Eigen::Index j = 0; j < q.size(); ++j)
      check_point(q[j], j, spec, nullptr, {table.path, table.lines[i], 1},
                  spec.model.chain.independent[j].name);
    spec.configurations.points.push_back(q);
  }
}

void refuse_for(const Object& o, const std::string& method, const std::vector<std::string_view>& keys) {
  for (const std::string_view key : keys)
    if (o.has(key))
      o.at(key).refuse("cannot be combined with method: " + method, "leave it out, or change the method");
}

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

/// Whether a column is neither of a joint, nor a signal of a log: perhaps of a joint by another name.
bool is_stray(const LogHeader& column, const Chain& chain) {
  const std::vector<std::string> joints = joint_names(chain);
  return !column.text.empty() && column.meaning.signal != "time" &&
         !contains(log_signal_names(chain), column.meaning.signal) &&
         std::ranges::none_of(joints, [&](const auto& j) { return rank_of(column, j).has_value(); });
}

/// @param may_rest  whether a joint without a column is none, where no column is stray
std::optional<std::size_t> find_column(const LogTable& table, const Chain& chain, const std::string& joint,
                                       bool may_rest) {
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
  const bool strays =
      std::ranges::any_of(table.header(), [&](const LogHeader& column) { return is_stray(column, chain); });
  // A joint of which the file has counts or a velocity moves.
  const auto moves = std::ranges::find_if(table.header(), [&](const LogHeader& column) {
    return column.meaning.signal == joint + ".counts" || column.meaning.signal == joint + ".velocity";
  });
  if (best.empty() && may_rest && !strays && moves == table.header().end()) return std::nullopt;
  if (best.empty())
    throw Error(table.header()[0].place, joint, "the file has no column for this joint", "",
                did_you_mean(joint, names) + "; log: {columns: {" + joint + ".reference: COLUMN}} maps it" +
                    (may_rest ? "; without columns of other names it would rest at 0" : ""));
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

void read_configurations(const Field& f, const std::string& folder, const RobotModel& robot, Spec& spec,
                         Faults& faults) {
  Node absent{Node::Type::mapping, {spec.file, 1, 1}, {}, false, {}, {}};
  const Object o(f.node ? f : Field{&absent, "configurations"}, spec_format::configurations);
  Configurations& c = spec.configurations;
  c.ranges = read_ranges(o, robot, spec, faults);
  const std::string method = o.choice("method");
  c.seed = static_cast<std::uint64_t>(*o.number("seed"));
  if (faults.any()) return;  // points are checked against the ranges
  if (method == "list" || method == "file") {
    c.method = SamplingMethod::list;
    refuse_for(o, method, {"count", method == "list" ? "file" : "points"});
    if (method == "list")
      read_points(o, spec);
    else
      read_point_file(o, folder, spec);
    return;
  }
  for (const auto& [key, needed] : {std::pair{"points", "list"}, {"file", "file"}})
    if (o.has(key) && !o.has("method"))
      o.at(key).refuse(std::string("needs 'method: ") + needed + "' beside it",
                       std::string("add 'method: ") + needed + "'");
  refuse_for(o, method, {"points", "file"});
  c.method = method == "sobol"    ? SamplingMethod::sobol
             : method == "random" ? SamplingMethod::random
                                  : SamplingMethod::grid;
  if (method == "sobol" && c.ranges.size() > most_sobol_joints) {
    c.method = SamplingMethod::random;
    spec.warnings.push_back("configurations: method random in place of sobol, whose sequence has at most " +
                            counted(most_sobol_joints, "joint"));
  }
  c.count = static_cast<std::uint64_t>(o.number("count").value_or(method == "grid" ? 10 : 10000));
  if (static_cast<double>(size(c)) > most_grid_points)
    throw Error(o.self().node->place, "configurations.count", "the grid has too many points",
                std::to_string(c.count) + "^" + std::to_string(c.ranges.size()),
                "use fewer per joint, or method: sobol");
}

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
    const auto time =
        std::ranges::find_if(table.header(), [](const LogHeader& h) { return h.meaning.signal == "time"; });
    if (time == table.header().end())
      throw Error(table.header()[0].place, "time", "the file has no column for the time", "",
                  "add a column 'time [s]', or say which it is: log: {time: COLUMN}");
    columns.push_back(static_cast<std::size_t>(time - table.header().begin()));
  }
  std::vector<std::optional<std::size_t>> places;  // of the joints in a row of the chosen columns
  std::vector<std::string> resting;
  for (const IndependentJoint& joint : chain.independent) {
    const auto column = find_column(table, chain, joint.name, has_time);
    places.push_back(column ? std::optional(columns.size()) : std::nullopt);
    units.push_back(column ? column_unit(table.header()[*column], joint.name, coordinate_dimension(joint))
                           : Unit{1, 1, coordinate_dimension(joint)});
    if (column)
      columns.push_back(*column);
    else
      resting.push_back(joint.name);
  }
  if (!resting.empty())
    warnings.push_back(table.file() + ": no column of " + list_of_names(resting) +
                       ": at rest at 0, like a joint that `motion.joints` does not list");
  const std::size_t first_load = columns.size();
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
    for (std::size_t i = 0; i < units.size(); ++i)
      positions.push_back(places[i] ? units[i].in_si(row[*places[i]]) : 0);
    for (std::size_t i = 0; i < loads.size(); ++i)
      load_values.push_back(loads[i].scale.in_si(row[first_load + i]));
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
  result.positions = Eigen::Map<const Eigen::MatrixXd>(positions.data(), std::ssize(chain.independent),
                                                       std::ssize(result.lines));
  for (auto* signals : {&result.efforts, &result.temperatures}) signals->resize(chain.independent.size());
  const Eigen::Map<const Eigen::MatrixXd> by_row(load_values.data(), std::ssize(loads),
                                                 std::ssize(result.lines));
  for (std::size_t i = 0; i < loads.size(); ++i)
    (loads[i].signal == LogSignal::effort ? result.efforts : result.temperatures)[loads[i].index] = {
        loads[i].unit, by_row.row(i)};
  return result;
}

}  // namespace qerr
