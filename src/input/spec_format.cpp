#include "input/spec_format.hpp"

#include <algorithm>

#include "qerr/bound/figure.hpp"
#include "qerr/filter/family.hpp"

namespace qerr::spec_format {

namespace {

/// The keys of a filter and those of all representations of a designed filter. Which of the latter are
/// required together depends on the representation and is checked by the reader.
std::vector<Parameter> with_representations(std::vector<Parameter> rows) {
  for (const FilterRepresentation& r : filter_representations()) {
    rows.push_back(r.key);
    for (Parameter p : r.beside) {
      p.required = false;
      rows.push_back(p);
    }
  }
  return rows;
}

}  // namespace

const std::vector<Parameter>& top() {
  static const std::vector<Parameter> rows{
      {.name = "qerr",
       .kind = Kind::integer,
       .meaning = "version of this format",
       .required = true,
       .least = 1,
       .most = 1},
      {.name = "robot", .kind = Kind::object, .meaning = "the kinematic chain", .required = true},
      {.name = "encoders",
       .kind = Kind::map,
       .meaning = "one encoder per moving joint; keys may be patterns: '*' is every joint without an "
                  "entry of its own",
       .required = true},
      {.name = "coupling",
       .kind = Kind::any,
       .meaning = "joint angles = coupling * (encoder angles / gear ratio), rows of numbers in chain order"},
      {.name = "coordinates",
       .kind = Kind::any,
       .meaning = "of the tip: x y z rx ry rz roll pitch yaw, and the lengths xyz and rxyz; and joints: "
                  "their names, "
                  "or `joints` for all"},
      {.name = "frame",
       .kind = Kind::choice,
       .meaning = "in whose axes x y z rx ry rz are",
       .choices = "base|tip"},
      {.name = "filters", .kind = Kind::map, .meaning = "derivative filters by name"},
      {.name = "estimators",
       .kind = Kind::map,
       .meaning = "velocity estimators that are no linear filter, by name; for simulate --estimators"},
      {.name = "control",
       .kind = Kind::object,
       .meaning = "the joints' controllers: what errors do to torques"},
      {.name = "walls",
       .kind = Kind::map,
       .meaning = "virtual walls at the tip, by name: how stiff they may be and stay passive"},
      {.name = "configurations",
       .kind = Kind::object,
       .meaning = "configurations at which the robot is evaluated"},
      {.name = "requirements",
       .kind = Kind::objects,
       .meaning = "limits that `qerr check` compares the figures with"},
      {.name = "threshold", .kind = Kind::object, .meaning = "for `qerr threshold`"},
      {.name = "motion", .kind = Kind::object, .meaning = "for `qerr simulate`"},
      {.name = "effects", .kind = Kind::objects, .meaning = "what the real robot adds to the ideal model"},
      {.name = "log", .kind = Kind::object, .meaning = "how `qerr diagnose` reads a log"},
      {.name = "sweep", .kind = Kind::objects, .meaning = "axes of the grid of `qerr sweep`"},
      {.name = "design", .kind = Kind::object, .meaning = "what `qerr design` may choose, and by what"},
  };
  return rows;
}

const std::vector<Parameter>& robot() {
  static const std::vector<Parameter> rows{
      {.name = "urdf", .kind = Kind::text, .meaning = "path of the URDF, relative to this file"},
      {.name = "joint",
       .kind = Kind::object,
       .meaning = "in place of a URDF: a robot of one joint, such as a rotary table"},
      {.name = "dh",
       .kind = Kind::objects,
       .meaning = "in place of a URDF: a table of Denavit and Hartenberg, a row a link"},
      {.name = "convention",
       .kind = Kind::choice,
       .meaning =
           "of dh: R_z(theta) T_z(d) T_x(a) R_x(alpha), or R_x(alpha) T_x(a) R_z(theta) T_z(d) (Craig)",
       .choices = "standard|modified"},
      {.name = "base", .kind = Kind::text, .meaning = "base link; default: the root"},
      {.name = "tip", .kind = Kind::text, .meaning = "tip link; optional if the tree has one leaf"},
      {.name = "tips",
       .kind = Kind::map,
       .meaning = "several tips in place of one, {left: LINK, right: LINK}: coordinates are left.x, and "
                  "right-left.x for one relative to the other, in the axes of the other"},
      {.name = "tool", .kind = Kind::object, .meaning = "moves the tip: its pose in the tip link"},
      {.name = "tracker",
       .kind = Kind::object,
       .meaning = "of a log's tip.x, tip.y and tip.z: the pose of the base in the frame of the tracker"},
  };
  return rows;
}

const std::vector<Parameter>& joint() {
  static const std::vector<Parameter> rows{
      {.name = "name", .kind = Kind::text, .meaning = "of the joint", .required = true},
      {.name = "type",
       .kind = Kind::choice,
       .meaning = "about the axis z, or along x",
       .choices = "revolute|prismatic"},
      {.name = "radius",
       .dimension = dimension::length,
       .meaning = "distance of the tip from the axis of a revolute joint, such as 100 mm; default: 0",
       .least = 0},
      {.name = "limits",
       .kind = Kind::any,
       .meaning = "[lower, upper]; default of a revolute joint: endless"},
      {.name = "velocity",
       .meaning =
           "largest speed, as of a URDF's limit: of rates of counts, and of slow errors behind a filter",
       .least = 0,
       .open_below = true,
       .coordinate = true},
  };
  return rows;
}

const std::vector<Parameter>& dh_row() {
  static const std::vector<Parameter> rows{
      {.name = "theta",
       .kind = Kind::any,
       .meaning = "angle about z: a joint's variable such as q2, with an offset: q2 - 90 deg; or a constant"},
      {.name = "d", .kind = Kind::any, .meaning = "distance along z, or the variable of a prismatic joint"},
      {.name = "a",
       .dimension = dimension::length,
       .meaning = "distance along x, such as 300 mm; default: 0"},
      {.name = "alpha",
       .dimension = dimension::angle,
       .meaning = "angle about x, such as -90 deg; default: 0"},
      {.name = "limits",
       .kind = Kind::any,
       .meaning = "[lower, upper] of the variable; default of a revolute joint: a turn"},
      {.name = "velocity",
       .meaning = "largest speed of the joint, as of a URDF's limit",
       .least = 0,
       .open_below = true,
       .coordinate = true},
  };
  return rows;
}

const std::vector<Parameter>& pose() {
  static const std::vector<Parameter> rows{
      {.name = "xyz",
       .kind = Kind::numbers,
       .dimension = dimension::length,
       .meaning = "of its origin, such as [0, 0, 120 mm]; default: 0"},
      {.name = "rpy",
       .kind = Kind::numbers,
       .dimension = dimension::angle,
       .meaning = "roll, pitch and yaw of its axes, as in a URDF; default: 0"},
  };
  return rows;
}

const std::vector<Parameter>& filter() {
  static const std::vector<Parameter> rows = with_representations({
      {.name = "derivative",
       .kind = Kind::integer,
       .meaning = "order of the derivative it estimates",
       .fallback = 0.0,
       .least = 0,
       .most = max_derivative},
      {.name = "sample_rate",
       .dimension = dimension::frequency,
       .meaning = "sample rate",
       .required = true,
       .least = 0,
       .open_below = true},
      {.name = "lowpass", .kind = Kind::object, .meaning = "low-pass after the backward differences"},
      {.name = "joints",
       .kind = Kind::text,
       .meaning = "name or pattern of the joints whose coordinates it filters; default: all coordinates"},
      {.name = "unit",
       .kind = Kind::text,
       .meaning = "of the gain of a control law that coefficients give, output per input, such as N m/rad"},
  });
  return rows;
}

const std::vector<Parameter>& lowpass() {
  static const std::vector<Parameter> rows{
      {.name = "family", .kind = Kind::text, .meaning = "see `qerr list filters`", .required = true}};
  return rows;
}

const std::vector<Parameter>& configurations() {
  static const std::vector<Parameter> rows{
      {.name = "method",
       .kind = Kind::choice,
       .meaning = "how configurations are chosen",
       .choices = "sobol|random|grid|list|file"},
      {.name = "count",
       .kind = Kind::integer,
       .meaning = "configurations; of a grid, values per joint",
       .least = 1,
       .most = 1e12},
      {.name = "seed",
       .kind = Kind::integer,
       .meaning = "seed of sobol and random",
       .fallback = 1.0,
       .least = 0,
       .most = 0x1p53 - 1},  // 2^53 is also what 2^53 + 1 is read as
      {.name = "limits",
       .kind = Kind::map,
       .meaning = "[lower, upper] per joint or pattern of joints, within the URDF's"},
      {.name = "points",
       .kind = Kind::any,
       .meaning = "of a list: one list of joint values per configuration"},
      {.name = "file", .kind = Kind::text, .meaning = "of a file: a table or bag with one column per joint"},
  };
  return rows;
}

const std::vector<Parameter>& requirement() {
  static const std::string statistics = [] {
    std::string names;
    for (const StatisticKind& s : statistic_kinds())
      names += (names.empty() ? "" : "|") + std::string(s.name);
    return names + "|median|" + std::string(proven_statistic);
  }();
  static const std::vector<Parameter> rows{
      {.name = "quantity",
       .kind = Kind::text,
       .meaning = "position.COORDINATE.BOUND or FILTER.COORDINATE.BOUND, such as velocity.x.sigma; or "
                  "FILTER.FIGURE: h2_norm, l1_norm, delay, bandwidth, settling; or "
                  "encoder.JOINT.count_rate, loop.JOINT.FIGURE, wall.NAME.stiffness",
       .required = true},
      {.name = "statistic",
       .kind = Kind::choice,
       .meaning = "of a bound over the configurations",
       .choices = statistics},
      {.name = "at_most",
       .kind = Kind::any,
       .meaning = "the highest permitted value, in the quantity's unit"},
      {.name = "at_least", .kind = Kind::any, .meaning = "the lowest permitted value"},
  };
  return rows;
}

const std::vector<Parameter>& threshold() {
  static const std::vector<Parameter> rows{{.name = "length",
                                            .dimension = dimension::length,
                                            .meaning = "length l of Table IV",
                                            .required = true,
                                            .least = 0,
                                            .open_below = true,
                                            .usual = 20}};
  return rows;
}

const std::vector<Parameter>& motion() {
  static const std::vector<Parameter> rows{
      {.name = "sample_rate",
       .dimension = dimension::frequency,
       .meaning = "sample rate of the controller",
       .least = 0,
       .open_below = true},
      {.name = "duration",
       .dimension = dimension::time,
       .meaning = "length of the motion",
       .least = 0,
       .open_below = true},
      {.name = "settling",
       .dimension = dimension::time,
       .meaning = "start of the motion that statistics exclude",
       .least = 0},
      {.name = "joints", .kind = Kind::map, .meaning = "motion of each joint; the others stay at 0"},
      {.name = "file", .kind = Kind::text, .meaning = "a table or bag with time and one column per joint"},
  };
  return rows;
}

const std::vector<Parameter>& joint_motion() {
  static const std::vector<Parameter> rows{
      {.name = "center", .meaning = "middle of the motion", .fallback = 0.0, .coordinate = true},
      {.name = "sines", .kind = Kind::objects, .meaning = "sines added to it"},
      {.name = "velocity",
       .meaning = "constant velocity added to it [rad/s or m/s]",
       .fallback = 0.0,
       .coordinate = true},
      {.name = "moves",
       .kind = Kind::objects,
       .meaning = "instead: point-to-point moves from the center, repeated"},
  };
  return rows;
}

const std::vector<Parameter>& move() {
  static const std::vector<Parameter> rows{
      {.name = "to", .meaning = "position at its end", .required = true, .coordinate = true},
      {.name = "velocity",
       .meaning = "highest speed [rad/s or m/s]",
       .required = true,
       .least = 0,
       .open_below = true,
       .coordinate = true},
      {.name = "acceleration",
       .meaning = "highest acceleration [rad/s^2 or m/s^2]",
       .required = true,
       .least = 0,
       .open_below = true,
       .coordinate = true},
      {.name = "jerk",
       .meaning = "highest jerk [rad/s^3 or m/s^3]; if absent, a trapezoidal velocity",
       .least = 0,
       .open_below = true,
       .coordinate = true},
      {.name = "dwell",
       .dimension = dimension::time,
       .meaning = "pause after the move",
       .fallback = 0.0,
       .least = 0},
  };
  return rows;
}

const std::vector<Parameter>& sine() {
  static const std::vector<Parameter> rows{
      {.name = "amplitude", .meaning = "amplitude", .required = true, .least = 0, .coordinate = true},
      {.name = "frequency",
       .dimension = dimension::frequency,
       .meaning = "frequency",
       .required = true,
       .least = 0,
       .open_below = true},
      {.name = "phase", .dimension = dimension::angle, .meaning = "phase at time 0", .fallback = 0.0},
  };
  return rows;
}

const std::vector<Parameter>& effect() {
  static const std::vector<Parameter> rows{
      {.name = "type", .kind = Kind::text, .meaning = "see `qerr list effects`", .required = true},
      {.name = "joint",
       .kind = Kind::text,
       .meaning = "the joint it acts on, or a pattern such as 'left_*'",
       .required = true},
  };
  return rows;
}

const std::vector<Parameter>& control() {
  static const std::vector<Parameter> rows{
      {.name = "sample_rate",
       .dimension = dimension::frequency,
       .meaning = "of the loops; default: that of the velocity filters",
       .least = 0,
       .open_below = true},
      {.name = "delay",
       .dimension = dimension::time,
       .meaning = "from a reading to its torque, beyond the hold; default: one sample",
       .least = 0},
      {.name = "joints",
       .kind = Kind::map,
       .meaning = "controllers by joint or pattern: torque = kp (set point - q) - kd (filtered velocity)"},
      {.name = "tip",
       .kind = Kind::object,
       .meaning = "or an impedance of the tip, in place of gains of joints"},
  };
  return rows;
}

const std::vector<Parameter>& controller() {
  static const std::vector<Parameter> rows{
      {.name = "kp",
       .kind = Kind::any,
       .meaning = "stiffness, such as 400 N m/rad [N m/rad or N/m]; default: 0"},
      {.name = "kd",
       .kind = Kind::any,
       .meaning = "damping, such as 5 N m s/rad [N m s/rad or N s/m]; default: 0"},
      {.name = "velocity",
       .kind = Kind::text,
       .meaning = "name of the filter with derivative 1 that estimates the velocity"},
      {.name = "inertia",
       .kind = Kind::any,
       .meaning = "at the joint, the motor's included [kg m^2 or kg]; default: the URDF's links, at each "
                  "configuration"},
      {.name = "damping", .kind = Kind::any, .meaning = "viscous [N m s/rad or N s/m]; default in a loop: 0"},
      {.name = "friction", .kind = Kind::any, .meaning = "Coulomb friction [N m or N]; for walls"},
  };
  return rows;
}

const std::vector<Parameter>& tip_impedance() {
  static const std::vector<Parameter> rows{
      {.name = "stiffness",
       .kind = Kind::numbers,
       .dimension = {-1, 0, 0, 1},
       .meaning = "along x, y and z of the base, such as [2 kN/m, 2 kN/m, 1 kN/m]",
       .required = true},
      {.name = "damping",
       .kind = Kind::numbers,
       .dimension = {-1, 0, 1, 1},
       .meaning = "along x, y and z, such as [20 N s/m, 20 N s/m, 20 N s/m]; default: 0"},
      {.name = "velocity",
       .kind = Kind::text,
       .meaning = "name of the filter with derivative 1 that estimates the joints' velocities"},
  };
  return rows;
}

const std::vector<Parameter>& estimator() {
  static const std::vector<Parameter> rows{
      {.name = "kind",
       .kind = Kind::text,
       .meaning = "name of a row of `qerr list estimators`, which has the other keys",
       .required = true},
      {.name = "joints",
       .kind = Kind::text,
       .meaning = "name or pattern of the joints that have it; default: all"},
  };
  return rows;
}

const std::vector<Parameter>& wall() {
  static const std::vector<Parameter> rows{
      {.name = "normal",
       .kind = Kind::numbers,
       .meaning = "direction in the base frame, such as [0, 0, 1]",
       .required = true},
  };
  return rows;
}

const std::vector<Parameter>& log() {
  static const std::vector<Parameter> rows{
      {.name = "time",
       .kind = Kind::any,
       .meaning = "the column of the time stamps, or {column: t_ms, unit: ms}; default: the one called so"},
      {.name = "columns",
       .kind = Kind::map,
       .meaning =
           "the column of each signal that is not called so, such as a1.measured: /joint_states/a1/position, "
           "or {column: q1_link, unit: deg}"},
      {.name = "missing",
       .kind = Kind::choice,
       .meaning =
           "what becomes of a row with an empty cell: an error, the row is left out, or the last value "
           "of the column is held",
       .choices = "error|drop|hold"},
  };
  return rows;
}

const std::vector<Parameter>& log_column() {
  static const std::vector<Parameter> rows{
      {.name = "column",
       .kind = Kind::text,
       .meaning = "its header; 'column 3' of a file without one",
       .required = true},
      {.name = "unit", .kind = Kind::text, .meaning = "in place of that of the header, such as deg or ms"},
  };
  return rows;
}

const std::vector<Parameter>& sweep() {
  static const std::vector<Parameter> rows{
      {.name = "key", .kind = Kind::text, .meaning = "dotted path of the value that varies"},
      {.name = "keys", .kind = Kind::any, .meaning = "dotted paths of values that vary together"},
      {.name = "values", .kind = Kind::any, .meaning = "the values; of `keys` lists with a value for each"},
      {.name = "catalogue",
       .kind = Kind::text,
       .meaning = "CSV file, relative to this file: its rows are entries of encoders"},
      {.name = "from", .kind = Kind::any, .meaning = "first value of a range"},
      {.name = "to", .kind = Kind::any, .meaning = "last value of a range"},
      {.name = "count", .kind = Kind::integer, .meaning = "values in the range", .least = 2, .most = 1e5},
      {.name = "scale", .kind = Kind::choice, .meaning = "spacing of the range", .choices = "linear|log"},
  };
  return rows;
}

const std::vector<Parameter>& design() {
  static const std::vector<Parameter> rows{
      {.name = "minimize",
       .kind = Kind::text,
       .meaning = "price (default), resolution (the coarsest encoders), or a quantity of requirements"},
      {.name = "statistic",
       .kind = Kind::text,
       .meaning = "of a quantity that is minimized; default: that of its requirement, else max"},
      {.name = "budget", .kind = Kind::any, .meaning = "highest price, where a quantity is minimized"},
      {.name = "encoders",
       .kind = Kind::map,
       .meaning = "options by joint or pattern: a catalogue, or keys of an encoder with lists and ranges"},
      {.name = "filters", .kind = Kind::map, .meaning = "families, orders and cut-offs by filter"},
      {.name = "gains", .kind = Kind::map, .meaning = "kp and kd of controllers by joint or pattern"},
  };
  return rows;
}

const std::vector<Parameter>& design_filter() {
  static const std::vector<Parameter> rows{
      {.name = "families",
       .kind = Kind::any,
       .meaning = "list of families; default: all that order and cutoff determine"},
      {.name = "orders", .kind = Kind::any, .meaning = "such as 1..4 (default) or [2, 4]"},
      {.name = "cutoff",
       .kind = Kind::any,
       .meaning = "[lowest, highest], or one; default: 0.001 to 0.4 of the sample rate"},
      {.name = "delay",
       .dimension = dimension::time,
       .meaning = "highest group delay at 0 Hz",
       .least = 0,
       .open_below = true},
      {.name = "tracking", .kind = Kind::object, .meaning = "highest tracking error of a motion"},
  };
  return rows;
}

const std::vector<Parameter>& design_gains() {
  static const std::vector<Parameter> rows{
      {.name = "kp", .kind = Kind::any, .meaning = "values, such as [200 N m/rad, 400 N m/rad]"},
      {.name = "kd", .kind = Kind::any, .meaning = "values, such as [2 N m s/rad, 4 N m s/rad]"},
  };
  return rows;
}

const std::vector<Parameter>& design_tracking() {
  static const std::vector<Parameter> rows{
      {.name = "band",
       .dimension = dimension::frequency,
       .meaning = "highest frequency of the motion",
       .required = true,
       .least = 0,
       .open_below = true},
      {.name = "at_most",
       .meaning = "largest part of the true derivative, such as 2 %",
       .required = true,
       .least = 0,
       .most = 1,
       .open_below = true,
       .open_above = true},
  };
  return rows;
}

const std::vector<std::string_view>& file_keys() {
  static const std::vector<std::string_view> keys{"robot.urdf", "motion.file", "configurations.file",
                                                  "sweep[].catalogue", "design.encoders.*.catalogue"};
  return keys;
}

std::optional<Dimension> dimension_of(const std::string& path) {
  const std::size_t first = path.find('.'), last = path.rfind('.');
  if (first == std::string::npos) return std::nullopt;
  const std::string section = path.substr(0, first), key = path.substr(last + 1);
  std::vector<Parameter> rows;
  if (section == "filters" && path.substr(0, last).ends_with(".lowpass"))
    for (const FilterFamily& family : filter_families())
      rows.insert(rows.end(), family.parameters.begin(), family.parameters.end());
  else if (section == "filters")
    rows = filter();
  else if (first == last)
    rows = section == "threshold" ? threshold()
           : section == "control" ? control()
           : section == "motion"  ? motion()
                                  : rows;
  for (const Parameter& row : rows)
    if (row.name == key && row.kind == Kind::number && !row.coordinate) return row.dimension;
  return std::nullopt;
}

bool may_name_a_file(std::string_view key) {
  return std::any_of(file_keys().begin(), file_keys().end(), [&](std::string_view file_key) {
    return file_key.starts_with(key) && (file_key.size() == key.size() || file_key[key.size()] == '.');
  });
}

}  // namespace qerr::spec_format
