#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "report/analysis/control.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string degrees(const std::optional<double>& angle) {
  return angle ? significant(*angle * 180 / std::numbers::pi, 3) + " deg" : "-";
}

std::string hertz(const std::optional<double>& f) { return f ? readable(*f, "Hz") : "-"; }

ControlTable loop_table(const Spec& spec, const ControlReport& report) {
  std::vector<std::vector<std::string>> rows{{"", "inertia", "gain margin", "phase margin", "bandwidth",
                                              "limit cycle at most", "predicted on a count",
                                              "predicted on an edge", "torque step"}};
  for (const WorstLoop& l : report.loops) {
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const std::string unit = joint.prismatic() ? "m" : "rad", torque = joint.prismatic() ? "N" : "N m",
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
  const bool sampled = std::any_of(report.loops.begin(), report.loops.end(),
                                   [](const WorstLoop& l) { return l.largest_inertia > l.least_inertia; });
  std::string of_play, of_friction;
  for (const WorstLoop& l : report.loops) {
    if (!l.stable) continue;
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const auto& friction = spec.model.control->joints[l.joint].friction;
    if (l.cycle.on_edge)
      of_friction += (of_friction.empty() ? "" : ", ") + shown(joint.name) + ' ' +
                     readable(l.cycle.ending_friction, joint.prismatic() ? "N" : "N m") +
                     (!friction                             ? ""
                      : *friction > l.cycle.ending_friction ? " (less than stated)"
                                                            : " (more than stated)");
    if (l.cycle.play)
      of_play += (of_play.empty() ? "; play is predicted to keep alive: " : ", ") + shown(joint.name) + ' ' +
                 readable(l.cycle.play->amplitude, joint.prismatic() ? "m" : "rad") + " at " +
                 hertz(l.cycle.play->frequency);
  }
  return {
      sampled ? "Loops, at the worst inertia between these ends" : "Loops",
      std::move(rows),
      {std::string("limit cycle at most: ") +
       (sampled ? "whatever the motion; proven at each inertia, the worst of which is searched"
                : "proven, whatever the motion") +
       "; predicted: by the describing function of rounding, a first harmonic: short pulses may keep "
       "alive what it does not predict" +
       (of_friction.empty() ? "" : "; Coulomb friction that ends one between two counts: " + of_friction) +
       of_play}};
}

ControlTable wall_table(const Spec& spec, const ControlReport& report) {
  std::vector<std::vector<std::string>> rows{
      {"", "passive stiffness", "decided by", "joint", "limit of the rate", "limit of the counts"}};
  std::string places;
  for (const WorstWall& w : report.walls) {
    if (std::isinf(w.limit.stiffness())) {
      rows.push_back({shown(w.name), "felt by no joint", "-", "-", "-", "-"});
      continue;
    }
    rows.push_back({shown(w.name), readable(w.limit.stiffness(), "N/m"),
                    w.limit.by_quantization() ? "counts, friction" : "rate, damping",
                    shown(spec.model.chain.independent[w.limit.joint()].name), readable(w.sampling, "N/m"),
                    readable(w.quantization, "N/m")});
    places += (places.empty() ? "least at " : "; ") + shown(w.name) + ": ";
    for (Eigen::Index j = 0; j < w.at.size(); ++j)
      places += (j ? ", " : "") + shown(spec.model.chain.independent[static_cast<std::size_t>(j)].name) +
                ' ' + significant(w.at[j], 4);
  }
  return {"Virtual walls: the least stiffness over the configurations that stays passive",
          std::move(rows),
          {places,
           "a finer encoder helps up to the limit of the rate, a faster loop or a shorter delay up to that "
           "of the counts"}};
}

std::string gain_line(const Spec& spec, const ControlReport& report) {
  std::string text;
  for (const GainReport& g : report.gains) {
    const IndependentJoint& joint = spec.model.chain.independent[g.joint];
    text += (text.empty() ? "" : "; ") + shown(joint.name) + ' ' +
            (g.kd > 0 ? significant(g.kd, 4) + (joint.prismatic() ? " N s/m" : " N m s/rad") : "none") +
            " (" + g.quantity + ')';
  }
  return text.empty() ? "" : "largest kd that meets the requirements, loop open: " + text;
}

ControlTable torque_table(const Spec& spec, const ControlReport& report) {
  const auto& joints = spec.model.chain.independent;
  const bool limited = std::any_of(report.torques.begin(), report.torques.end(),
                                   [](const OpenTorque& t) { return t.relative.has_value(); });
  std::vector<std::vector<std::string>> rows{{"", "worst case"}};
  if (limited) rows[0].emplace_back("of the effort limit");
  rows[0].emplace_back("encoders' parts of it");
  for (const OpenTorque& t : report.torques) {
    std::string parts;
    for (Eigen::Index e = 0; e < t.share.size(); ++e)
      if (constexpr double shown_from = 0.005; t.share[e] >= shown_from)
        parts += (parts.empty() ? "" : ", ") + shown(joints[static_cast<std::size_t>(e)].name) + ' ' +
                 percent(t.share[e]);
    rows.push_back(
        {shown(joints[t.joint].name), readable(t.worst_case, joints[t.joint].prismatic() ? "N" : "N m")});
    if (limited) rows.back().push_back(t.relative ? significant(100 * *t.relative, 3) + " %" : "-");
    rows.back().push_back(parts);
  }
  return {"Torques due to errors, the loops open", std::move(rows), {}};
}

}  // namespace

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
