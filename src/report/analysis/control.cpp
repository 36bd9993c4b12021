#include "control/control.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/loop_response.hpp"
#include "core/text.hpp"
#include "report/analysis/figures.hpp"

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
  const NamedFilter& f = spec.filters[r.filter];
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
    const auto known = std::ranges::find_if(gains, [&](const GainReport& g) { return g.joint == *joint; });
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
        std::ranges::any_of(spec.requirements,
                            [&](const Requirement& r) { return r.of_control && r.quantity == f.name; }))
      return true;
  return false;
}

/// Joints whose readings are delayed or multiplied in a way that is not in the loops: those of a coupled
/// transmission, and at walls all that are multiplied. "" if there are none.
/// @param joint  of the loop; empty: of any
std::string uncounted_readings(const Spec& spec, std::optional<std::size_t> joint, bool of_walls) {
  std::vector<std::string> all;
  const Eigen::MatrixXd coupling = spec.model.transmission.coupling.dense();
  for (std::size_t j = 0; j < spec.model.control->joints.size(); ++j) {
    const LoopReading& r = spec.model.control->joints[j].reading;
    const auto at = static_cast<Eigen::Index>(j);
    const bool alone = (coupling.row(at).array() != 0).count() == 1 &&
                       (coupling.col(at).array() != 0).count() == 1,
               concerned = !joint || coupling(*joint, at) != 0;
    if (concerned && ((of_walls && r.factor != 1) || (!alone && (r.factor != 1 || r.delay != 0))))
      all.push_back(spec.model.chain.independent[j].name);
  }
  return joined(all);
}

constexpr const char* about_uncounted =
    "delayed (latency) or multiplied (scale, decoding), which is not counted there";

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

std::string degrees(const std::optional<double>& angle) {
  return angle ? significant(*angle * 180 / std::numbers::pi, 3) + " deg" : "-";
}

std::string hertz(const std::optional<double>& f) { return f ? readable(*f, "Hz") : "-"; }

ControlTable loop_table(const Spec& spec, const ControlReport& report) {
  TableRows rows{{"", "inertia", "gain margin", "phase margin", "bandwidth", "limit cycle at most",
                  "predicted on a count", "predicted on an edge", "torque step"}};
  for (const WorstLoop& l : report.loops) {
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const std::string unit = joint.unit(), torque = joint.effort_unit(),
                      mass = joint.prismatic() ? "kg" : "kg m^2";
    std::string inertia = significant(l.least_inertia, 3);
    if (l.largest_inertia > l.least_inertia * 1.001) inertia += " .. " + significant(l.largest_inertia, 3);
    if (!l.stable) {
      rows.push_back(
          {shown(joint.name), inertia + ' ' + mass, "unstable", "-", "-", "unbounded", "-", "-", "-"});
      continue;
    }
    const LimitCycle& c = l.cycle;
    rows.push_back({shown(joint.name), inertia + ' ' + mass,
                    std::isinf(l.margins.gain) ? "inf" : significant(l.margins.gain, 4),
                    degrees(l.margins.phase), hertz(l.margins.bandwidth), readable(c.bound, unit),
                    c.on_count ? "yes" : "no",
                    c.on_edge ? readable(c.edge_amplitude, unit) + " at " + hertz(c.frequency) : "no",
                    readable(c.torque_step, torque)});
  }
  const bool sampled = std::ranges::any_of(
      report.loops, [](const WorstLoop& l) { return l.largest_inertia > l.least_inertia; });
  std::vector<std::string> of_play, of_friction;
  for (const WorstLoop& l : report.loops) {
    if (!l.stable) continue;
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const auto& friction = spec.model.control->joints[l.joint].friction;
    if (l.cycle.on_edge)
      of_friction.push_back(shown(joint.name) + ' ' + readable(l.cycle.ending_friction, joint.effort_unit()) +
                            (!friction                             ? ""
                             : *friction > l.cycle.ending_friction ? " (less than stated)"
                                                                   : " (more than stated)"));
    if (l.cycle.play)
      of_play.push_back(shown(joint.name) + ' ' + readable(l.cycle.play->amplitude, joint.unit()) + " at " +
                        hertz(l.cycle.play->frequency));
  }
  return {
      sampled ? "Loops, at the worst inertia between these ends" : "Loops",
      std::move(rows),
      {std::string("limit cycle at most: ") +
       (sampled ? "whatever the motion; proven at each inertia, the worst of which is searched"
                : "proven, whatever the motion") +
       "; predicted: by the describing function of rounding, a first harmonic: short pulses may keep "
       "alive what it does not predict" +
       (of_friction.empty() ? ""
                            : "; Coulomb friction that ends one between two counts: " + joined(of_friction)) +
       (of_play.empty() ? "" : "; play is predicted to keep alive: " + joined(of_play))}};
}

ControlTable wall_table(const Spec& spec, const ControlReport& report) {
  TableRows rows{
      {"", "passive stiffness", "decided by", "joint", "limit of the rate", "limit of the counts"}};
  std::vector<std::string> places;
  for (const WorstWall& w : report.walls) {
    if (std::isinf(w.limit.stiffness())) {
      rows.push_back({shown(w.name), "felt by no joint", "-", "-", "-", "-"});
      continue;
    }
    rows.push_back({shown(w.name), readable(w.limit.stiffness(), "N/m"),
                    w.limit.by_quantization() ? "counts, friction" : "rate, damping",
                    shown(spec.model.chain.independent[w.limit.joint()].name), readable(w.sampling, "N/m"),
                    readable(w.quantization, "N/m")});
    places.push_back(shown(w.name) + ": " +
                     configuration_text(spec.model.chain, w.at, [](const auto& joint, double value) {
                       return shown(joint.name) + ' ' + significant(value, 4);
                     }));
  }
  return {"Virtual walls: the least stiffness over the configurations that stays passive",
          std::move(rows),
          {(places.empty() ? "" : "least at ") + joined(places, "; "),
           "a finer encoder helps up to the limit of the rate, a faster loop or a shorter delay up to that "
           "of the counts"}};
}

std::string gain_line(const Spec& spec, const ControlReport& report) {
  if (report.gains.empty()) return "";
  return "largest kd that meets the requirements, loop open: " +
         joined(report.gains, "; ", [&](const GainReport& g) {
           const IndependentJoint& joint = spec.model.chain.independent[g.joint];
           return shown(joint.name) + ' ' +
                  (g.kd > 0 ? significant(g.kd, 4) + (joint.prismatic() ? " N s/m" : " N m s/rad") : "none") +
                  " (" + g.quantity + ')';
         });
}

ControlTable torque_table(const Spec& spec, const ControlReport& report) {
  const auto& joints = spec.model.chain.independent;
  const bool limited =
      std::ranges::any_of(report.torques, [](const OpenTorque& t) { return t.relative.has_value(); });
  TableRows rows{{"", "worst case"}};
  if (limited) rows[0].emplace_back("of the effort limit");
  rows[0].emplace_back("encoders' parts of it");
  for (const OpenTorque& t : report.torques) {
    std::vector<std::string> parts;
    for (Eigen::Index e = 0; e < t.share.size(); ++e)
      if (constexpr double shown_from = 0.005; t.share[e] >= shown_from)
        parts.push_back(shown(joints[e].name) + ' ' + percent(t.share[e]));
    rows.push_back({shown(joints[t.joint].name), readable(t.worst_case, joints[t.joint].effort_unit())});
    if (limited) rows.back().push_back(t.relative ? significant(100 * *t.relative, 3) + " %" : "-");
    rows.back().push_back(joined(parts));
  }
  return {"Torques due to errors, the loops open", std::move(rows), {}};
}

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
  return std::ranges::any_of(spec.requirements, &Requirement::of_control);
}

double control_value(const Requirement& r, const Spec& spec, const ControlReport& report) {
  using Kind = ControlFigure::Kind;
  const Control& control = *spec.model.control;
  const auto fault = [&](const std::string& rule, const std::string& remedy) {
    return requirement_error(r, rule, remedy);
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
  std::vector<std::string> without;
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].acts() && !has_loop(control, chain, j))
      without.push_back(chain.independent[j].name);
  if (!without.empty())
    warnings.push_back("control: the loop of " + joined(without) +
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

std::vector<ControlTable> control_tables(const Spec& spec, const ControlReport& report) {
  std::vector<ControlTable> all;
  if (!report.torques.empty()) all.push_back(torque_table(spec, report));
  if (!report.loops.empty()) all.push_back(loop_table(spec, report));
  if (const std::string gains = gain_line(spec, report); !gains.empty()) {
    if (all.empty()) all.emplace_back();
    all.back().notes.push_back(gains);
  }
  if (!report.walls.empty()) all.push_back(wall_table(spec, report));
  return all;
}

std::string control_text(const Spec& spec, const ControlReport& report, const Style& style) {
  std::string out;
  for (const ControlTable& table : control_tables(spec, report)) {
    if (!table.rows.empty()) out += heading(table.title, style) + fitted_table(table.rows, style.width);
    for (const std::string& note : table.notes) out += wrapped(note, style.width, "  ");
  }
  return out;
}

}  // namespace qerr
