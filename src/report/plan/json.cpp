#include "report/formats.hpp"
#include "report/json_header.hpp"
#include "report/plan/parts.hpp"

namespace qerr {

namespace {

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
        other["correlation"] = r.correlation;
        other["told_apart"] = r.separable_from;
        other["record"] = r.record;
        correlated.push_back(other);
      }
      entry["parameter"] = p.parameter;
      entry["unit"] = size_unit(p, joint.prismatic);
      entry["seen"] = p.detectable;
      entry["named"] = p.identifiable;
      entry["seen_counts"] = p.detectable_counts();
      entry["named_counts"] = p.identifiable_counts();
      entry["alike"] = correlated;
      effects.push_back(entry);
    }
    for (const UndetectableEffect& u : joint.undetectable)
      undetectable.push_back({{"effect", u.effect}, {"needs", u.required}});
    list.push_back({{"joint", joint.joint},
                    {"unit", joint.prismatic ? "m" : "rad"},
                    {"resolution", joint.resolution},
                    {"moves", joint.moves},
                    {"readings", joint.readings},
                    {"effects", effects},
                    {"unseen", undetectable}});
  }
  return list;
}

}  // namespace

std::string to_json(const PlanReport& r, const Style&) {
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
  return j.document();
}

}  // namespace qerr
