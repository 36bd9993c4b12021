#include "report/analysis/control.hpp"

#include <algorithm>
#include <limits>

#include "control/figures.hpp"
#include "control/loop_response.hpp"
#include "core/text.hpp"

namespace qerr {

namespace {

constexpr double unknown_figure = std::numeric_limits<double>::quiet_NaN();

Eigen::MatrixXd first_configurations(const Spec& spec) {
  return draw(spec.configurations, 0, std::min(configurations_of_control, size(spec.configurations)));
}

/// The joint whose torque a requirement limits from above, with kp and kd; empty: none, or its spectrum is
/// not known without the errors' motion.
std::optional<std::size_t> limited_torque(const Spec& spec, const Requirement& r) {
  if (!r.limits_error() || r.at_least || r.filter < 0) return std::nullopt;
  const NamedFilter& f = spec.filters[static_cast<std::size_t>(r.filter)];
  const bool known = r.bound == Bound::worst_case ? !spec.model.along_motion
                                                  : r.bound == Bound::sigma && spec.model.sources.empty();
  if (!f.controller || !known || !(spec.model.control->joints[f.joints.front()].kd > 0)) return std::nullopt;
  return f.joints.front();
}

std::vector<GainReport> gain_reports(const Spec& spec) {
  std::vector<GainReport> gains;
  for (const Requirement& r : spec.requirements) {
    const std::optional<std::size_t> joint = limited_torque(spec, r);
    if (!joint) continue;
    const GainReport gain{*joint, largest_kd(spec.model, *joint, r.bound, r.limit), r.quantity};
    const auto known =
        std::find_if(gains.begin(), gains.end(), [&](const GainReport& g) { return g.joint == *joint; });
    if (known == gains.end())
      gains.push_back(gain);
    else if (gain.kd < known->kd)
      *known = gain;
  }
  return gains;
}

/// Whether a requirement names a figure of the joint's loop.
bool is_required(const Spec& spec, std::size_t joint) {
  for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
    if (f.kind != ControlFigure::Kind::wall_stiffness && f.index == joint &&
        std::any_of(spec.requirements.begin(), spec.requirements.end(),
                    [&](const Requirement& r) { return r.of_control && r.quantity == f.name; }))
      return true;
  return false;
}

/// Joints whose readings are delayed or multiplied in a way that is not in the loops: those of a coupled
/// transmission, and at walls all that are multiplied. "" if there are none.
/// @param joint  of the loop; empty: of any
std::string uncounted_readings(const Spec& spec, std::optional<std::size_t> joint, bool of_walls) {
  std::string all;
  const Eigen::MatrixXd coupling = spec.model.transmission.coupling.dense();
  for (std::size_t j = 0; j < spec.model.control->joints.size(); ++j) {
    const LoopReading& r = spec.model.control->joints[j].reading;
    const auto at = static_cast<Eigen::Index>(j);
    const bool alone = (coupling.row(at).array() != 0).count() == 1 &&
                       (coupling.col(at).array() != 0).count() == 1,
               concerned = !joint || coupling(static_cast<Eigen::Index>(*joint), at) != 0;
    if (concerned && ((of_walls && r.factor != 1) || (!alone && (r.factor != 1 || r.delay != 0))))
      all += (all.empty() ? "" : ", ") + spec.model.chain.independent[j].name;
  }
  return all;
}

constexpr const char* about_uncounted =
    "delayed (latency) or multiplied (scale, decoding), which is not counted there";

}  // namespace

void refuse_changed_loops(const Spec& spec) {
  if (!spec.model.control) return;
  const std::vector<Signal> signals = all_signals(spec.model);
  const std::vector<ControlFigure> figures = control_figures(*spec.model.control, spec.model.chain);
  std::vector<Fault> faults;
  for (const Requirement& r : spec.requirements) {
    std::optional<std::size_t> joint;  // of the only loop that the figure depends on
    bool of_walls = false;
    for (const ControlFigure& f : figures)
      if (r.of_control && f.name == r.quantity) {
        of_walls = f.kind == ControlFigure::Kind::wall_stiffness;
        if (!of_walls) joint = f.index;
      }
    if (!r.of_control && !(r.limits_error() && is_closed(signals[r.signal]))) continue;
    if (const std::string joints = uncounted_readings(spec, joint, of_walls); !joints.empty())
      faults.push_back(
          {r.place, "requirements", "readings of " + joints + " are " + about_uncounted, quoted(r.quantity),
           "state a latency as control.delay, a factor in the gains; leave the effect out here"});
  }
  if (!faults.empty()) throw Error(faults);
}

ControlReport control_report(const Spec& spec, bool required_only) {
  ControlReport report;
  if (!spec.model.control) return report;
  const Control& control = *spec.model.control;
  report.gains = gain_reports(spec);
  const Eigen::MatrixXd configurations = first_configurations(spec);
  if (configurations.cols() == 0) return report;
  std::vector<std::size_t> joints;
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (has_loop(control, spec.model.chain, j) && (!required_only || is_required(spec, j)))
      joints.push_back(j);
  if (!required_only) report.torques = open_torques(spec.model, configurations);
  report.loops = worst_loops(spec.model, joints, configurations);
  if (!control.walls.empty() && missing_for_walls(control, spec.model.chain).empty())
    for (const Wall& wall : control.walls)
      report.walls.push_back(worst_wall(spec.model, wall, configurations));
  return report;
}

bool any_of_control(const Spec& spec) {
  return std::any_of(spec.requirements.begin(), spec.requirements.end(),
                     [](const Requirement& r) { return r.of_control; });
}

namespace {

/// The value of a figure: infinite if unbounded, NaN for an unstable loop; empty if something is not stated.
std::optional<double> value_of(const ControlFigure& f, const ControlReport& report) {
  using Kind = ControlFigure::Kind;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (f.kind == Kind::wall_stiffness)
    return f.index < report.walls.size() ? std::optional(report.walls[f.index].limit.stiffness())
                                         : std::nullopt;
  if (f.kind == Kind::largest_kd) {
    for (const GainReport& gain : report.gains)
      if (gain.joint == f.index) return gain.kd;
    return std::nullopt;
  }
  for (const WorstLoop& loop : report.loops) {
    if (loop.joint != f.index) continue;
    if (!loop.stable) return f.kind == Kind::limit_cycle ? infinity : unknown_figure;
    return f.kind == Kind::gain_margin    ? loop.margins.gain
           : f.kind == Kind::phase_margin ? loop.margins.phase.value_or(infinity)
           : f.kind == Kind::bandwidth    ? loop.margins.bandwidth.value_or(infinity)
                                          : loop.cycle.bound;
  }
  return std::nullopt;
}

}  // namespace

double control_value(const Requirement& r, const Spec& spec, const ControlReport& report) {
  using Kind = ControlFigure::Kind;
  const Control& control = *spec.model.control;
  const auto fault = [&](const std::string& rule, const std::string& remedy) {
    return Error({r.place, "requirements", rule, quoted(r.quantity), remedy});
  };
  for (const ControlFigure& f : control_figures(control, spec.model.chain)) {
    if (f.name != r.quantity) continue;
    const std::optional<double> value = value_of(f, report);
    if (f.kind == Kind::wall_stiffness) {
      if (!value)
        throw fault("the stiffness of a wall needs damping and friction of all joints",
                    "state " + missing_for_walls(control, spec.model.chain) + " in control.joints");
      if (std::isinf(*value))
        throw fault("no joint feels this wall: it is unbounded at all configurations, which meets any limit",
                    "turn its normal to where the joints move the tip");
    }
    if (f.kind == Kind::largest_kd && !value)
      throw fault("the largest kd is that for a limit of the joint's torque",
                  "require at_most of torque." + spec.model.chain.independent[f.index].name +
                      ".worst_case or, without accuracy and effects, .sigma");
    if (!value) break;
    return f.kind == Kind::limit_cycle && r.at_least && std::isinf(*value) ? unknown_figure : *value;
  }
  throw fault("the figure has no value", "see `qerr analyze`");
}

std::vector<SingleFigure> control_rows(const Spec& spec, const ControlReport& report) {
  using Kind = ControlFigure::Kind;
  std::vector<SingleFigure> rows;
  for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain)) {
    const std::optional<double> value = value_of(f, report);
    if (!value) continue;
    const bool wall = f.kind == Kind::wall_stiffness;
    // Rows carry no warning: what a requirement is refused on is not known.
    const bool counted = f.kind == Kind::largest_kd ||
                         uncounted_readings(spec, wall ? std::nullopt : std::optional(f.index), wall).empty();
    rows.push_back({f.name, unit_name(f.dimension), f.kind == Kind::limit_cycle ? "max" : "min",
                    counted ? *value : unknown_figure});
  }
  return rows;
}

std::vector<std::string> control_warnings(const Spec& spec, const ControlReport& report) {
  std::vector<std::string> warnings;
  if (!spec.model.control) return warnings;
  const Control& control = *spec.model.control;
  const Chain& chain = spec.model.chain;
  std::string without;
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].acts() && !has_loop(control, chain, j))
      without += (without.empty() ? "" : ", ") + chain.independent[j].name;
  if (!without.empty())
    warnings.push_back("control: the loop of " + without +
                       " is not closed: its inertia is not known; state 'inertia:'" +
                       (spec.model.tips ? ", as the masses beyond several tips are not added up"
                                        : ", or give the URDF's links their masses"));
  if (const std::string joints = uncounted_readings(spec, {}, !control.walls.empty()); !joints.empty())
    warnings.push_back("control: in loops of coupled joints" +
                       std::string(control.walls.empty() ? "" : " and walls") + " readings of " + joints +
                       " are " + about_uncounted);
  for (const WorstLoop& l : report.loops)
    if (!l.stable)
      warnings.push_back(
          "control: the loop of joint '" + chain.independent[l.joint].name +
          "' is unstable at an inertia of " +
          readable(l.unstable_inertia, chain.independent[l.joint].prismatic() ? "kg" : "kg m^2") +
          ", its errors are unbounded; " +
          (l.margins.gain > 0 ? "it is stable below " + significant(l.margins.gain, 4) + " times its gains"
                              : "no smaller gain makes it stable"));
  const std::string missing = missing_for_walls(control, chain);
  if (!control.walls.empty() && !missing.empty())
    warnings.push_back("walls: no stiffness is given; state " + missing + " in control.joints");
  return warnings;
}

}  // namespace qerr
