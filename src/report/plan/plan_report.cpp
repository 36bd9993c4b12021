#include "qerr/report/plan_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/plan/plan_writers.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: a size that no effect reaches is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json effect_json(const Effect& e) {
  Json j = {{"effect", e.type}};
  for (const auto& [choice, word] : e.choices) j[choice] = word;
  for (const char* name : {"order", "time_constant"})
    if (e.numbers.contains(name)) j[name] = e.number(name);
  return j;
}

Json joints_json(const std::vector<PlannedJoint>& joints) {
  Json list = Json::array();
  for (const PlannedJoint& joint : joints) {
    Json effects = Json::array(), undetectable = Json::array();
    for (const PlannedEffect& p : joint.effects) {
      Json correlated = Json::array(), entry = effect_json(p.effect);
      for (const CorrelatedEffect& r : p.correlated) {
        Json other = effect_json(r.effect);
        other["correlation"] = number(r.correlation);
        other["told_apart"] = number(r.separable_from);
        other["record"] = r.record;
        correlated.push_back(other);
      }
      entry["parameter"] = p.parameter;
      entry["unit"] = size_unit(p, joint.prismatic);
      entry["seen"] = number(p.detectable);
      entry["named"] = number(p.identifiable);
      entry["seen_counts"] = number(p.detectable_counts());
      entry["named_counts"] = number(p.identifiable_counts());
      entry["alike"] = correlated;
      effects.push_back(entry);
    }
    for (const UndetectableEffect& u : joint.undetectable)
      undetectable.push_back({{"effect", u.effect}, {"needs", u.required}});
    list.push_back({{"joint", joint.joint},
                    {"unit", joint.prismatic ? "m" : "rad"},
                    {"resolution", joint.resolution},
                    {"moves", joint.moves},
                    {"readings", number(joint.readings)},
                    {"effects", effects},
                    {"unseen", undetectable}});
  }
  return list;
}

void add_rows(std::string& out, const char* motion, const std::vector<PlannedJoint>& joints) {
  const auto cell = [](double value) { return std::isfinite(value) ? shortest(value) : std::string(); };
  for (const PlannedJoint& joint : joints)
    for (const PlannedEffect& p : joint.effects) {
      std::string twins;
      for (const CorrelatedEffect& r : p.correlated)
        if (r.inseparable()) twins += (twins.empty() ? "" : "; ") + family_of(r.effect);
      const auto shaft = p.effect.choices.find("shaft");
      out += std::string(motion) + ',' + csv_cell(joint.joint) + ',' + p.effect.type + ',' +
             (shaft == p.effect.choices.end() ? "" : shaft->second) + ',' +
             (p.effect.numbers.contains("order") ? shortest(p.effect.number("order")) : "") + ',' +
             (p.effect.numbers.contains("time_constant") ? shortest(p.effect.number("time_constant")) : "") +
             ',' + p.parameter + ',' + cell(p.detectable) + ',' + cell(p.identifiable) + ',' +
             size_unit(p, joint.prismatic) + ',' + cell(p.detectable_counts()) + ',' +
             cell(p.identifiable_counts()) + ',' + csv_cell(twins) + "\r\n";
    }
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
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  }) && !(name[0] >= '0' && name[0] <= '9');
  return plain ? name : Json(name).dump();
}

}  // namespace

PlanReport plan_report(const Spec& spec, const PlanOptions& options) {
  if (!spec.motion)
    throw Error(Fault{{spec.file, 1, 1},
                      "motion",
                      "the spec has no motion to plan with",
                      "",
                      "add motion: {sample_rate: 1 kHz, duration: 10 s, joints: {...}}"});
  PlanReport report{spec, plan(spec.model, spec.effects, *spec.motion, options), spec.warnings};
  if (options.reference_noise > 0.3)
    report.warnings.push_back(
        "a reference with a noise of more than 0.3 counts is hardly better than the encoders");
  return report;
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

std::string size_unit(const PlannedEffect& p, bool prismatic) {
  for (const Parameter& row : effect_kind(p.effect.type).parameters)
    if (row.name == p.parameter) return unit_name(dimension_at(row, prismatic));
  return "";
}

std::string family_of(const Effect& e) {
  const auto shaft = e.choices.find("shaft");
  return e.type + (shaft != e.choices.end() && shaft->second == "joint" ? " (joint)" : "");
}

std::string to_json(const PlanReport& r) {
  Json better = nullptr;
  if (r.plan.better) {
    Json changed = Json::array();
    for (const std::size_t j : r.plan.changed) changed.push_back(r.spec.model.chain.independent[j].name);
    better = {{"motion", motion_text(*r.plan.better, r.spec.model.chain)},
              {"changed", changed},
              {"joints", joints_json(r.plan.joints_better)}};
  }
  const Json j = {{"qerr", version()},
                  {"command", "diagnose --plan"},
                  {"spec", {{"file", r.spec.file}, {"sha256", r.spec.sha256}}},
                  {"reference_noise", r.plan.options.reference_noise},
                  {"power", r.plan.options.power},
                  {"joints", joints_json(r.plan.joints)},
                  {"better", better},
                  {"warnings", r.warnings}};
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string to_csv(const PlanReport& r) {
  std::string out =
      "motion,joint,effect,shaft,order,time_constant,parameter,seen,named,unit,seen_counts,named_counts,"
      "cannot_be_told_from\r\n";
  add_rows(out, "planned", r.plan.joints);
  add_rows(out, "better", r.plan.joints_better);
  return out;
}

std::string write(const PlanReport& r, std::string_view format, const Style& style) {
  return format == "json" ? to_json(r) : format == "csv" ? to_csv(r) : to_table(r, style);
}

}  // namespace qerr
