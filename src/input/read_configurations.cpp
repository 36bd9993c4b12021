#include <algorithm>
#include <filesystem>
#include <limits>
#include <numbers>

#include "core/lists.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"

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
      q[static_cast<Eigen::Index>(j)] = read_number(values[j], {.name = "points", .coordinate = true},
                                                    coordinate_dimension(spec.model.chain.independent[j]));
      check_point(q[static_cast<Eigen::Index>(j)], j, spec, &values[j], {}, values[j].path);
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
      check_point(q[j], static_cast<std::size_t>(j), spec, nullptr,
                  {table.path, table.lines[static_cast<std::size_t>(i)], 1},
                  spec.model.chain.independent[static_cast<std::size_t>(j)].name);
    spec.configurations.points.push_back(q);
  }
}

void refuse_for(const Object& o, const std::string& method, const std::vector<std::string_view>& keys) {
  for (const std::string_view key : keys)
    if (o.has(key))
      o.at(key).refuse("cannot be combined with method: " + method, "leave it out, or change the method");
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

}  // namespace qerr
