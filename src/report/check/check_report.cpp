#include <algorithm>

#include "core/text.hpp"
#include "qerr/report/comparison.hpp"
#include "report/check/parts.hpp"
#include "report/compare/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

bool SpecCheck::all_met() const {
  return std::all_of(results.begin(), results.end(), [](const RequirementResult& r) { return r.met; }) &&
         (!baseline || baseline->regressions.empty());
}

SpecCheck check(const Spec& spec, const WorkspaceOptions& options, const Baseline* baseline,
                const ProofRequest& proofs) {
  if (spec.requirements.empty() && !baseline)
    throw Error(
        Fault{{spec.file, 1, 1},
              "requirements",
              "the spec has none: there is nothing to check",
              "",
              "add `requirements:` (see `qerr schema` and `qerr list statistics`), or compare with an "
              "earlier report: --baseline OLD.json"});
  SpecCheck report = evaluate(spec, options, proofs);
  if (!baseline) return report;
  report.baseline = against(*baseline, named_figures(report));
  for (const std::string& warning : report.baseline->warnings) report.analysis.warnings.push_back(warning);
  return report;
}

bool CheckReport::all_met() const {
  return broken.empty() &&
         std::all_of(specs.begin(), specs.end(), [](const SpecCheck& s) { return s.all_met(); });
}

std::string verdict(const BaselineCheck& b) {
  const std::string tolerance = b.tolerance > 0 ? " by more than " + percent(b.tolerance) : "";
  return (b.regressions.empty() ? "none" : std::to_string(b.regressions.size())) + " of " +
         counted(b.compared, "figure") + " worse than in " + b.file + tolerance;
}

std::string verdict(const FigureChange& c) {
  return c.figure.name() + " was " + readable(*c.a, c.figure.unit) + " and is " +
         readable(*c.b, c.figure.unit) + " (" + change_text(c) + ")";
}

}  // namespace qerr
