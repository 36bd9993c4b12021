#include <algorithm>

#include "core/text.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/effects.hpp"
#include "report/check/parts.hpp"

namespace qerr {

bool SpecCheck::all_met() const {
  return std::all_of(results.begin(), results.end(), [](const RequirementResult& r) { return r.met; });
}

SpecCheck check(const Spec& spec, const WorkspaceOptions& options) {
  if (spec.requirements.empty())
    throw Error(Fault{{spec.file, 1, 1},
                      "requirements",
                      "the spec has none: there is nothing to check",
                      "",
                      "add `requirements:` (see `qerr schema` and `qerr list statistics`)"});
  EffectReport effects = effect_report(spec);
  require_known(spec, effects.shares);
  SpecCheck report{analyze(spec, std::move(effects), options), {}};
  for (const Requirement& r : spec.requirements)
    report.results.push_back(
        evaluate(r, report.analysis.workspace, designed_filters(spec), filter_norms(spec)));
  return report;
}

bool CheckReport::all_met() const {
  return std::all_of(specs.begin(), specs.end(), [](const SpecCheck& s) { return s.all_met(); });
}

std::string verdict(const Requirement& r, const RequirementResult& result) {
  return r.name() + " is " + readable(result.value, r.unit) + ", " + (r.at_least ? "at least " : "at most ") +
         readable(r.limit, r.unit) + " is required";
}

}  // namespace qerr
