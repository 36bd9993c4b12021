#include <algorithm>

#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/json_value.hpp"
#include "report/plan/parts.hpp"

namespace qerr {

PlanReport plan_report(const Spec& spec, const PlanOptions& options) {
  if (!spec.motion)
    throw Error(Fault{{spec.file, 1, 1},
                      "motion",
                      "the spec has no motion to plan with",
                      "",
                      "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}"});
  PlanReport report{spec, plan(spec.model, spec.effects, *spec.motion, options), spec.warnings};
  if (options.reference_noise > 0.3)
    report.warnings.emplace_back(
        "a reference with a noise of more than 0.3 counts is hardly better than the encoders");
  return report;
}

std::string size_unit(const PlannedEffect& p, bool prismatic) {
  for (const Parameter& row : effect_kind(p.effect.type).parameters)
    if (row.name == p.parameter) return unit_name(dimension_at(row, prismatic));
  return "";
}

std::string family_of(const Effect& e) {
  const auto shaft = e.choices.find("shaft");
  return e.type + (shaft != e.choices.end() && shaft->second == "joint" ? " (joint)" : "");
}

namespace {

void add_rows(std::string& out, const char* motion, const std::vector<PlannedJoint>& joints) {
  for (const PlannedJoint& joint : joints) {
    const Json json = json_of(joint);
    for (std::size_t i = 0; i < joint.effects.size(); ++i) {
      std::string twins;
      for (const CorrelatedEffect& r : joint.effects[i].correlated)
        if (r.inseparable()) twins += (twins.empty() ? "" : "; ") + family_of(r.effect);
      out += std::string(motion) + ',' + csv_cell(joint.joint) + ',' +
             csv_cells((*json.find("effects")->items())[i],
                       {"effect", "shaft", "order", "time_constant", "parameter", "seen", "named", "unit",
                        "seen_counts", "named_counts"}) +
             ',' + csv_cell(twins) + "\r\n";
    }
  }
}

}  // namespace

std::string to_csv(const PlanReport& r, const Style&) {
  std::string out =
      "motion,joint,effect,shaft,order,time_constant,parameter,seen,named,unit,seen_counts,named_counts,"
      "cannot_be_told_from\r\n";
  add_rows(out, "planned", r.plan.joints);
  add_rows(out, "better", r.plan.joints_better);
  return out;
}

namespace {

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

}  // namespace

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
             return b.whole.plan.changed |
                    std::views::transform([&](std::size_t j) { return joints[j].name; });
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

namespace {

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
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  }) && !(name[0] >= '0' && name[0] <= '9');
  return plain ? name : Json(name).line();
}

}  // namespace

std::string motion_text(const Motion& m, const Chain& chain) {
  std::string out = "motion:\n  sample_rate: " + shortest(m.sample_rate) +
                    " Hz\n  duration: " + shortest(m.duration) + " s\n";
  if (m.settling) out += "  settling: " + shortest(*m.settling) + " s\n";
  out += "  joints:\n";
  for (std::size_t j = 0; j < m.joints.size(); ++j)
    out += "    " + key_text(chain.independent[j].name) + ": " + joint_motion_text(m.joints[j]) + '\n';
  return out;
}

}  // namespace qerr
