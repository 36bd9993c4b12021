#include "qerr/report/plan_report.hpp"

#include "qerr/core/error.hpp"
#include "qerr/effect/effect_kind.hpp"
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

}  // namespace qerr
