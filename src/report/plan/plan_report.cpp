#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "report/analysis/figures.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// SI unit of the parameter that states a planned effect's size; "" for a pure number.
std::string size_unit(const PlannedEffect& p, bool prismatic) {
  for (const Parameter& row : effect_kind(p.effect.type).parameters)
    if (row.name == p.parameter) return unit_name(dimension_at(row, prismatic));
  return "";
}

/// An effect with its shaft, without its order: `eccentricity (joint)`.
std::string family_of(const Effect& e) {
  const auto shaft = e.choices.find("shaft");
  return e.type + (shaft != e.choices.end() && shaft->second == "joint" ? " (joint)" : "");
}

/// Every pair of families that are not distinguishable with its joints, grouped by what to record to
/// distinguish them.
std::string twins(const std::vector<PlannedJoint>& joints) {
  using Pair = std::pair<std::string, std::string>;
  std::map<Pair, std::vector<std::string>> where;
  std::map<Pair, std::string> record;  // of the pair in alphabetical order
  for (const PlannedJoint& joint : joints) {
    std::set<Pair> found;
    for (const PlannedEffect& p : joint.effects)
      for (const CorrelatedEffect& r : p.correlated) {
        if (!r.inseparable()) continue;
        const std::string a = family_of(p.effect), b = family_of(r.effect);
        record.emplace(std::minmax(a, b), r.record);
        if (!found.contains({b, a})) found.insert({a, b});
      }
    for (const Pair& pair : found) where[pair].push_back(shown(joint.joint));
  }
  std::map<std::string, std::vector<std::string>> by_record;
  for (const auto& [pair, names] : where) {
    const auto& [a, b] = pair;
    by_record[record.at(std::minmax(a, b))].push_back(
        (a == b ? a + " of two different orders" : a + " and " + b) + ": " + joined(names));
  }
  std::string out;
  for (const auto& [advice, lines] : by_record) {
    for (const std::string& line : lines) out += "  " + line + '\n';
    out += "    to distinguish them, record " + advice + '\n';
  }
  return out;
}

void add_rows(std::string& out, const char* motion, const std::vector<PlannedJoint>& joints) {
  for (const PlannedJoint& joint : joints) {
    const Json json = json_of(joint);
    for (std::size_t i = 0; i < joint.effects.size(); ++i) {
      std::vector<std::string> twins;
      for (const CorrelatedEffect& r : joint.effects[i].correlated)
        if (r.inseparable()) twins.push_back(family_of(r.effect));
      out += std::string(motion) + ',' + csv_cell(joint.joint) + ',' +
             csv_cells(json.at("effects")[i], {"effect", "shaft", "order", "time_constant", "parameter",
                                               "seen", "named", "unit", "seen_counts", "named_counts"}) +
             ',' + csv_cell(joined(twins, "; ")) + "\r\n";
    }
  }
}

using JointEffect = In<PlannedEffect, PlannedJoint>;

using BetterMotion = In<Motion, PlanReport>;

/// An effect with the choices and the figures that tell it from others of its type.
template <class Entry, class Planned>
RowsOf<Entry> effect_rows(Effect Planned::*effect) {
  const auto number = [effect](const char* name) {
    return [=](const Entry& e) {
      const Effect& of = std::invoke(effect, e);
      return of.numbers.contains(name) ? std::optional(of.number(name)) : std::nullopt;
    };
  };
  return {{"effect", [effect](auto& e) { return std::invoke(effect, e).type; }},
          {"shaft",
           [effect](auto& e) {
             const Effect& of = std::invoke(effect, e);
             return of.choices.contains("shaft") ? of.choices.at("shaft") : "";
           },
           optional},
          {"order", number("order"), optional},
          {"time_constant", number("time_constant"), optional}};
}

std::string joint_motion_text(const JointMotion& m) {
  std::string out = "{center: " + shortest(m.center);
  if (m.velocity != 0) out += ", velocity: " + shortest(m.velocity);
  if (!m.sines.empty()) {
    out += ", sines: [";
    for (const Sine& s : m.sines)
      out += (&s == &m.sines.front() ? "{amplitude: " : ", {amplitude: ") + shortest(s.amplitude) +
             ", frequency: " + shortest(s.frequency) + (s.phase != 0 ? ", phase: " + shortest(s.phase) : "") +
             '}';
    out += ']';
  }
  if (!m.moves.empty()) {
    out += ", moves: [";
    for (const Move& x : m.moves)
      out += std::string(&x == &m.moves.front() ? "" : ",") + "\n      {to: " + shortest(x.to) +
             ", velocity: " + shortest(x.velocity) + ", acceleration: " + shortest(x.acceleration) +
             (x.jerk > 0 ? ", jerk: " + shortest(x.jerk) : "") + ", dwell: " + shortest(x.dwell) + '}';
    out += ']';
  }
  return out + '}';
}

/// A name as a key of YAML: in quotes unless it is plain.
std::string key_text(const std::string& name) {
  const bool plain = !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  }) && !(name[0] >= '0' && name[0] <= '9');
  return plain ? name : line(name);
}

/// The largest of the sizes over all orders and time constants of one family.
struct Cell {
  double detectable = 0, identifiable = 0;  // [counts]
};

std::optional<Cell> cell_of(const PlannedJoint& joint, const std::string& family) {
  std::optional<Cell> worst;
  for (const PlannedEffect& p : joint.effects) {
    if (family_of(p.effect) != family) continue;
    if (!worst) worst.emplace();
    worst->detectable = std::max(worst->detectable, p.detectable_counts());
    worst->identifiable = std::max(worst->identifiable, p.identifiable_counts());
  }
  return worst;
}

std::string text_of(const std::optional<Cell>& cell) {
  if (!cell) return "";
  if (!std::isfinite(cell->detectable)) return "none";
  return std::isfinite(cell->identifiable) ? significant(cell->identifiable, 2)
                                           : significant(cell->detectable, 2) + " ?";
}

std::vector<std::string> families(const std::vector<PlannedJoint>& joints) {
  std::vector<std::string> list;
  for (const PlannedJoint& joint : joints)
    for (const PlannedEffect& p : joint.effects) add_once(list, family_of(p.effect));
  return list;
}

/// Smallest sizes in counts: one row per effect, one column per joint that moves.
std::string matrix(const std::vector<PlannedJoint>& joints) {
  TableRows rows{{""}};
  for (const PlannedJoint& joint : joints)
    if (joint.moves) rows[0].push_back(shown(joint.joint));
  for (const std::string& family : families(joints)) {
    std::vector<std::string>& row = rows.emplace_back(1, family);
    for (const PlannedJoint& joint : joints)
      if (joint.moves) row.push_back(text_of(cell_of(joint, family)));
  }
  return aligned(rows);
}

std::size_t named_count(const PlannedJoint& joint) {
  std::size_t count = 0;
  for (const std::string& family : families({joint}))
    if (const auto cell = cell_of(joint, family); cell && std::isfinite(cell->identifiable)) ++count;
  return count;
}

/// One line per joint: the number of identifiable effects, in this and in the better motion.
std::string summary(const PlanReport& r) {
  const Plan& p = r.plan;
  TableRows rows{{"joint", "readings", "effects", "identifiable", "better motion"}};
  for (std::size_t j = 0; j < p.joints.size(); ++j) {
    const PlannedJoint& joint = p.joints[j];
    const bool changed = contains(p.changed, j);
    rows.push_back({shown(joint.joint), significant(std::round(joint.readings), 6),
                    joint.moves ? std::to_string(families({joint}).size()) : "",
                    joint.moves ? std::to_string(named_count(joint)) : "not moving: no verdict",
                    changed ? std::to_string(named_count(p.joints_better[j])) + " of " +
                                  std::to_string(families({p.joints_better[j]}).size())
                            : ""});
  }
  return aligned(rows);
}

std::string undetectable(const std::vector<PlannedJoint>& joints) {
  std::vector<std::string> lines;
  for (const PlannedJoint& joint : joints)
    for (const UndetectableEffect& u : joint.undetectable) {
      std::string required = escaped(u.required, 200);
      const std::string own = shown(joint.joint) + ".";
      if (const auto at = required.find(own); at != std::string::npos)
        required.replace(at, own.size(), "JOINT.");
      add_once(lines, "  " + u.effect + " needs " + required + '\n');
    }
  return joined(lines, "") +
         "  truncation is an offset of half a count in every motion; a datum distinguishes them\n";
}

std::string assumptions(const Plan& p) {
  return "Assumed: a reference of every encoder with a noise of " +
         significant(p.options.reference_noise, 3) +
         " counts;\neffects of the sizes below are identified with a probability of " +
         significant(100 * p.options.power, 3) + " %.\n";
}

std::string full_table(const PlanReport& r, const Style& style) {
  const Plan& p = r.plan;
  std::string out = painted("qerr diagnose --plan", Paint::bold, style) + "  robot '" +
                    shown(r.spec.robot_name) + "', " + significant(r.spec.motion->duration, 6) + " s at " +
                    readable(r.spec.motion->sample_rate, "Hz") + "\n\n" + assumptions(p) + '\n' + summary(r);
  const bool any = std::ranges::any_of(p.joints, [](const auto& j) { return j.moves; });
  if (any) {
    out += heading("Smallest identifiable size [counts, peak of what the effect adds]", style) +
           matrix(p.joints) +
           "  ?: detectable from this size on, identifiable at none; none: not detectable\n";
    if (const std::string list = twins(p.joints); !list.empty())
      out += heading("Not distinguishable in this motion", style) + list;
    out += heading("Not detectable in this log", style) + undetectable(p.joints);
  }
  if (!p.better) return out + "\nNone of the motions tried identifies clearly more.\n";
  out += heading(
             "With a better motion (same length and rate; only the joints' limits are known: check it for "
             "collisions)",
             style) +
         matrix(p.joints_better);
  if (const std::string list = twins(p.joints_better); !list.empty())
    out += heading("Still not distinguishable", style) + list;
  return out + heading("The better motion, for the spec", style) + motion_text(*p.better, r.spec.model.chain);
}

}  // namespace

RowsOf<PlannedJoint> rows(Of<PlannedJoint>);

PlanReport plan_report(const Spec& spec, const PlanOptions& options) {
  if (!spec.motion)
    throw spec_error(spec, "motion", "the spec has no motion to plan with", "",
                     "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}");
  PlanReport report{spec, plan(spec.model, spec.effects, *spec.motion, options), spec.warnings};
  if (options.reference_noise > 0.3)
    report.warnings.emplace_back(
        "a reference with a noise of more than 0.3 counts is hardly better than the encoders");
  return report;
}

std::string to_csv(const PlanReport& r, const Style&) {
  std::string out =
      "motion,joint,effect,shaft,order,time_constant,parameter,seen,named,unit,seen_counts,named_counts,"
      "cannot_be_told_from\r\n";
  add_rows(out, "planned", r.plan.joints);
  add_rows(out, "better", r.plan.joints_better);
  return out;
}

RowsOf<CorrelatedEffect> rows(Of<CorrelatedEffect>) {
  return effect_rows<CorrelatedEffect>(&CorrelatedEffect::effect)
      .with({{"correlation", &CorrelatedEffect::correlation},
             {"told_apart", &CorrelatedEffect::separable_from, "from this magnitude on", nullable},
             {"record", &CorrelatedEffect::record, "what tells them apart"}});
}

RowsOf<JointEffect> rows(Of<JointEffect>) {
  return effect_rows<JointEffect>(&PlannedEffect::effect)
      .with({{"parameter", &PlannedEffect::parameter},
             {"unit", [](auto& e) { return size_unit(*e, e.whole.prismatic); }},
             {"seen", &PlannedEffect::detectable, "smallest detectable magnitude", nullable},
             {"named", &PlannedEffect::identifiable, "smallest identifiable magnitude", nullable},
             {"seen_counts", &PlannedEffect::detectable_counts, nullable},
             {"named_counts", &PlannedEffect::identifiable_counts, nullable},
             {"alike", &PlannedEffect::correlated}});
}

RowsOf<UndetectableEffect> rows(Of<UndetectableEffect>) {
  return {{"effect", &UndetectableEffect::effect}, {"needs", &UndetectableEffect::required}};
}

RowsOf<PlannedJoint> rows(Of<PlannedJoint>) {
  return {{"joint", &PlannedJoint::joint},
          {"unit", [](auto& j) { return j.prismatic ? "m" : "rad"; }},
          {"resolution", &PlannedJoint::resolution},
          {"moves", &PlannedJoint::moves},
          {"readings", &PlannedJoint::readings, "independent ones"},
          {"effects", within(&PlannedJoint::effects)},
          {"unseen", &PlannedJoint::undetectable}};
}

RowsOf<BetterMotion> rows(Of<BetterMotion>) {
  return {{"motion", [](auto& b) { return motion_text(*b, b.whole.spec.model.chain); }, "YAML to paste"},
          {"changed",
           [](auto& b) {
             const auto& joints = b.whole.spec.model.chain.independent;
             return each(b.whole.plan.changed, [&](std::size_t j) { return joints[j].name; });
           },
           "joints"},
          {"joints", [](auto& b) { return b.whole.plan.joints_better; }}};
}

RowsOf<PlanReport> rows(Of<PlanReport>) {
  return header<PlanReport>("diagnose --plan")
      .with({{"spec",
              {{"file", [](auto& r) { return r.spec.file; }},
               {"sha256", [](auto& r) { return r.spec.sha256; }}}},
             {"reference_noise", [](auto& r) { return r.plan.options.reference_noise; }, "counts"},
             {"power", [](auto& r) { return r.plan.options.power; }},
             {"joints", [](auto& r) { return r.plan.joints; }},
             {"better", within([](auto& r) { return r.plan.better; }), "a motion that identifies more"},
             {"warnings", &PlanReport::warnings}});
}

std::string motion_text(const Motion& m, const Chain& chain) {
  std::string out = "motion:\n  sample_rate: " + shortest(m.sample_rate) +
                    " Hz\n  duration: " + shortest(m.duration) + " s\n";
  if (m.settling) out += "  settling: " + shortest(*m.settling) + " s\n";
  out += "  joints:\n";
  for (std::size_t j = 0; j < m.joints.size(); ++j)
    out += "    " + key_text(chain.independent[j].name) + ": " + joint_motion_text(m.joints[j]) + '\n';
  return out;
}

std::string to_table(const PlanReport& r, const Style& style) {
  return within(full_table(r, style), style.width);
}

}  // namespace qerr
