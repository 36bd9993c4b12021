#include <algorithm>

#include "input/read_sections.hpp"
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

const std::vector<Parameter> top{
    key::integer("qerr", "version of this format").within(1, 1).needed(),
    key::object("robot", "the kinematic chain").needed(),
    key::map("encoders",
             "one encoder per moving joint; keys may be patterns: '*' is every joint without an entry of "
             "its own")
        .needed(),
    key::any("coupling",
             "joint angles = coupling * (encoder angles / gear ratio), rows of numbers in chain order"),
    key::any("coordinates",
             "of the tip: x y z rx ry rz roll pitch yaw, and the lengths xyz and rxyz; and joints: their "
             "names, or `joints` for all"),
    key::choice("frame", "base|tip", "in whose axes x y z rx ry rz are"),
    key::map("filters", "derivative filters by name"),
    key::map("estimators",
             "velocity estimators that are no linear filter, by name; for simulate --estimators"),
    key::object("control", "the joints' controllers: what errors do to torques"),
    key::map("walls", "virtual walls at the tip, by name: how stiff they may be and stay passive"),
    key::object("configurations", "configurations at which the robot is evaluated"),
    key::objects("requirements", "limits that `qerr check` compares the figures with"),
    key::object("threshold", "for `qerr threshold`"),
    key::object("motion", "for `qerr simulate`"),
    key::objects("effects", "what the real robot adds to the ideal model"),
    key::object("log", "how `qerr diagnose` reads a log"),
    key::objects("sweep", "axes of the grid of `qerr sweep`"),
    key::object("design", "what `qerr design` may choose, and by what"),
};

const std::vector<Parameter> robot{
    key::text("urdf", "path of the URDF, relative to this file"),
    key::object("joint", "in place of a URDF: a robot of one joint, such as a rotary table"),
    key::objects("dh", "in place of a URDF: a table of Denavit and Hartenberg, a row a link"),
    key::choice("convention", "standard|modified",
                "of dh: R_z(theta) T_z(d) T_x(a) R_x(alpha), or R_x(alpha) T_x(a) R_z(theta) T_z(d) (Craig)"),
    key::text("name",
              "of the robot in reports; default: that of the URDF, of its one joint, or of this file"),
    key::text("base", "base link; default: the root"),
    key::text("tip", "tip link; optional if the tree has one leaf"),
    key::map("tips",
             "several tips in place of one, {left: LINK, right: LINK}: coordinates are left.x, and "
             "right-left.x for one relative to the other, in the axes of the other"),
    key::object("tool", "moves the tip: its pose in the tip link"),
    key::object("tracker",
                "of a log's tip.x, tip.y and tip.z: the pose of the base in the frame of the tracker"),
};

const std::vector<Parameter> joint{
    key::text("name", "of the joint").needed(),
    key::choice("type", "revolute|prismatic", "about the axis z, or along x"),
    key::number("radius", "distance of the tip from the axis of a revolute joint, such as 100 mm; default: 0",
                dimension::length)
        .from(0),
    key::any("limits", "[lower, upper]; default of a revolute joint: endless"),
    key::coordinate(
        "velocity",
        "largest speed, as of a URDF's limit: of rates of counts, and of slow errors behind a filter")
        .above(0),
};

const std::vector<Parameter> dh_row{
    key::any("theta",
             "angle about z: a joint's variable such as q2, with an offset: q2 - 90 deg; or a constant"),
    key::any("d", "distance along z, or the variable of a prismatic joint"),
    key::number("a", "distance along x, such as 300 mm; default: 0", dimension::length),
    key::number("alpha", "angle about x, such as -90 deg; default: 0", dimension::angle),
    key::any("limits", "[lower, upper] of the variable; default of a revolute joint: a turn"),
    key::coordinate("velocity", "largest speed of the joint, as of a URDF's limit").above(0),
};

const std::vector<Parameter> pose{
    key::numbers("xyz", "of its origin, such as [0, 0, 120 mm]; default: 0", dimension::length),
    key::numbers("rpy", "roll, pitch and yaw of its axes, as in a URDF; default: 0", dimension::angle),
};

const std::vector<Parameter>& filter() {
  static const std::vector<Parameter> rows = with_representations({
      key::integer("derivative", "order of the derivative it estimates")
          .otherwise(0.0)
          .within(0, max_derivative),
      key::number("sample_rate", "sample rate", dimension::frequency).above(0).needed(),
      key::object("lowpass", "low-pass after the backward differences"),
      key::text("joints",
                "name or pattern of the joints whose coordinates it filters; default: all coordinates"),
      key::text("unit",
                "of the gain of a control law that coefficients give, output per input, such as N m/rad"),
  });
  return rows;
}

const std::vector<Parameter> lowpass{key::text("family", "see `qerr list filters`").needed()};

const std::vector<Parameter> configurations{
    key::choice("method", "sobol|random|grid|list|file", "how configurations are chosen"),
    key::integer("count", "configurations; of a grid, values per joint").within(1, 1e12),
    key::integer("seed", "seed of sobol and random")
        .otherwise(1.0)
        .within(0, 0x1p53 - 1),  // 2^53 is also what 2^53 + 1 is read as
    key::map("limits", "[lower, upper] per joint or pattern of joints, within the URDF's"),
    key::any("points", "of a list: one list of joint values per configuration"),
    key::text("file", "of a file: a table or bag with one column per joint"),
};

const std::vector<Parameter>& requirement() {
  static const std::string statistics = [] {
    std::string names;
    for (const StatisticKind& s : statistic_kinds())
      names += (names.empty() ? "" : "|") + std::string(s.name);
    return names + "|median|" + std::string(proven_statistic);
  }();
  static const std::vector<Parameter> rows{
      key::text("quantity",
                "position.COORDINATE.BOUND or FILTER.COORDINATE.BOUND, such as velocity.x.sigma; or "
                "FILTER.FIGURE: h2_norm, l1_norm, delay, bandwidth, settling; or encoder.JOINT.count_rate, "
                "loop.JOINT.FIGURE, wall.NAME.stiffness")
          .needed(),
      key::choice("statistic", statistics, "of a bound over the configurations"),
      key::any("at_most", "the highest permitted value, in the quantity's unit"),
      key::any("at_least", "the lowest permitted value"),
  };
  return rows;
}

const std::vector<Parameter> threshold{
    key::number("length", "length l of Table IV", dimension::length).above(0).usually_below(20).needed()};

const std::vector<Parameter> motion{
    key::number("sample_rate", "sample rate of the controller", dimension::frequency).above(0),
    key::number("duration", "length of the motion", dimension::time).above(0),
    key::number("settling", "start of the motion that statistics exclude", dimension::time).from(0),
    key::map("joints", "motion of each joint; the others stay at 0"),
    key::text("file", "a table or bag with time and one column per joint"),
};

const std::vector<Parameter> joint_motion{
    key::coordinate("center", "middle of the motion").otherwise(0.0),
    key::objects("sines", "sines added to it"),
    key::coordinate("velocity", "constant velocity added to it [rad/s or m/s]").otherwise(0.0),
    key::objects("moves", "instead: point-to-point moves from the center, repeated"),
};

const std::vector<Parameter> move{
    key::coordinate("to", "position at its end").needed(),
    key::coordinate("velocity", "highest speed [rad/s or m/s]").above(0).needed(),
    key::coordinate("acceleration", "highest acceleration [rad/s^2 or m/s^2]").above(0).needed(),
    key::coordinate("jerk", "highest jerk [rad/s^3 or m/s^3]; if absent, a trapezoidal velocity").above(0),
    key::number("dwell", "pause after the move", dimension::time).otherwise(0.0).from(0),
};

const std::vector<Parameter> sine{
    key::coordinate("amplitude", "amplitude").from(0).needed(),
    key::number("frequency", "frequency", dimension::frequency).above(0).needed(),
    key::number("phase", "phase at time 0", dimension::angle).otherwise(0.0),
};

const std::vector<Parameter> effect{
    key::text("type", "see `qerr list effects`").needed(),
    key::text("joint", "the joint it acts on, or a pattern such as 'left_*'").needed(),
};

const std::vector<Parameter> control{
    key::number("sample_rate", "of the loops; default: that of the velocity filters", dimension::frequency)
        .above(0),
    key::number("delay", "from a reading to its torque, beyond the hold; default: one sample",
                dimension::time)
        .from(0),
    key::map("joints",
             "controllers by joint or pattern: torque = kp (set point - q) - kd (filtered velocity)"),
    key::object("tip", "or an impedance of the tip, in place of gains of joints"),
};

const std::vector<Parameter> controller{
    key::any("kp", "stiffness, such as 400 N m/rad [N m/rad or N/m]; default: 0"),
    key::any("kd", "damping, such as 5 N m s/rad [N m s/rad or N s/m]; default: 0"),
    key::text("velocity", "name of the filter with derivative 1 that estimates the velocity"),
    key::any("inertia",
             "at the joint, the motor's included [kg m^2 or kg]; default: the URDF's links, at each "
             "configuration"),
    key::any("damping", "viscous [N m s/rad or N s/m]; default in a loop: 0"),
    key::any("friction", "Coulomb friction [N m or N]; for walls"),
};

const std::vector<Parameter> tip_impedance{
    key::numbers("stiffness", "along x, y and z of the base, such as [2 kN/m, 2 kN/m, 1 kN/m]", {-1, 0, 0, 1})
        .needed(),
    key::numbers("damping", "along x, y and z, such as [20 N s/m, 20 N s/m, 20 N s/m]; default: 0",
                 {-1, 0, 1, 1}),
    key::text("velocity", "name of the filter with derivative 1 that estimates the joints' velocities"),
};

const std::vector<Parameter> estimator{
    key::text("kind", "name of a row of `qerr list estimators`, which has the other keys").needed(),
    key::text("joints", "name or pattern of the joints that have it; default: all"),
};

const std::vector<Parameter> wall{
    key::numbers("normal", "direction in the base frame, such as [0, 0, 1]").needed(),
};

const std::vector<Parameter> log{
    key::any("time",
             "the column of the time stamps, or {column: t_ms, unit: ms}; default: the one called so"),
    key::map("columns",
             "the column of each signal that is not called so, such as a1.measured: "
             "/joint_states/a1/position, or {column: q1_link, unit: deg}"),
    key::choice("missing", "error|drop|hold",
                "what becomes of a row with an empty cell: an error, the row is left out, or the last "
                "value of the column is held"),
};

const std::vector<Parameter> log_column{
    key::text("column", "its header; 'column 3' of a file without one").needed(),
    key::text("unit", "in place of that of the header, such as deg or ms"),
};

const std::vector<Parameter> sweep{
    key::text("key", "dotted path of the value that varies"),
    key::any("keys", "dotted paths of values that vary together"),
    key::any("values", "the values; of `keys` lists with a value for each"),
    key::text("catalogue", "CSV file, relative to this file: its rows are entries of encoders"),
    key::any("from", "first value of a range"),
    key::any("to", "last value of a range"),
    key::integer("count", "values in the range").within(2, 1e5),
    key::choice("scale", "linear|log", "spacing of the range"),
};

const std::vector<Parameter> design{
    key::text("minimize",
              "price (default), resolution (the coarsest encoders), or a quantity of requirements"),
    key::text("statistic", "of a quantity that is minimized; default: that of its requirement, else max"),
    key::any("budget", "highest price, where a quantity is minimized"),
    key::map("encoders",
             "options by joint or pattern: a catalogue, or keys of an encoder with lists and ranges"),
    key::map("filters", "families, orders and cut-offs by filter"),
    key::map("gains", "kp and kd of controllers by joint or pattern"),
};

const std::vector<Parameter> design_filter{
    key::any("families", "list of families; default: all that order and cutoff determine"),
    key::any("orders", "such as 1..4 (default) or [2, 4]"),
    key::any("cutoff", "[lowest, highest], or one; default: 0.001 to 0.4 of the sample rate"),
    key::number("delay", "highest group delay at 0 Hz", dimension::time).above(0),
    key::object("tracking", "highest tracking error of a motion"),
};

const std::vector<Parameter> design_gains{
    key::any("kp", "values, such as [200 N m/rad, 400 N m/rad]"),
    key::any("kd", "values, such as [2 N m s/rad, 4 N m s/rad]"),
};

const std::vector<Parameter> design_tracking{
    key::number("band", "highest frequency of the motion", dimension::frequency).above(0).needed(),
    key::number("at_most", "largest part of the true derivative, such as 2 %").above(0).below(1).needed(),
};

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
    rows = section == "threshold" ? threshold
           : section == "control" ? control
           : section == "motion"  ? motion
                                  : rows;
  for (const Parameter& row : rows)
    if (row.name == key && row.kind == Kind::number && !row.coordinate) return row.dimension;
  return std::nullopt;
}

bool may_name_a_file(std::string_view key) {
  return std::ranges::any_of(file_keys(), [&](std::string_view file_key) {
    return file_key.starts_with(key) && (file_key.size() == key.size() || file_key[key.size()] == '.');
  });
}

}  // namespace qerr::spec_format
