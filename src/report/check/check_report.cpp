#include <algorithm>

#include "qerr/report/analysis.hpp"
#include "report/analysis/effects.hpp"

namespace qerr {

bool CheckReport::all_met() const {
  return std::all_of(results.begin(), results.end(), [](const RequirementResult& r) { return r.met; });
}

CheckReport check_report(const Spec& spec, const WorkspaceOptions& options) {
  EffectReport effects = effect_report(spec);
  require_known(spec, effects.shares);
  CheckReport report{analyze(spec, std::move(effects), options), {}};
  for (const Requirement& r : spec.requirements)
    report.results.push_back(evaluate(r, report.analysis.workspace));
  if (spec.requirements.empty())
    report.analysis.warnings.emplace_back("the spec has no requirements: nothing was checked");
  return report;
}

}  // namespace qerr
