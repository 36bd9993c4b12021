#include <algorithm>
#include <chrono>

#include "core/text.hpp"
#include "qerr/report/comparison.hpp"
#include "report/analysis/effects.hpp"
#include "report/check/parts.hpp"
#include "report/compare/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

bool SpecCheck::all_met() const {
  return std::all_of(results.begin(), results.end(), [](const RequirementResult& r) { return r.met; }) &&
         (!baseline || baseline->regressions.empty());
}

std::vector<RequirementResult> requirement_results(const Analysis& a) {
  const std::vector<Filter> filters = designed_filters(a.spec);
  const std::vector<Norms> norms = filter_norms(a.spec);
  std::vector<RequirementResult> results;
  for (const Requirement& r : a.spec.requirements)
    results.push_back(r.proven ? evaluate(r, *find_proof(a, proven_figure(r, a.spec.model)))
                               : evaluate(r, a.workspace, filters, norms));
  return results;
}

SpecCheck evaluate(const Spec& spec, const WorkspaceOptions& options, const ProofRequest& proofs) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  EffectReport effects = effect_report(spec);
  require_known(spec, effects.shares);
  SpecCheck report{analyze(spec, std::move(effects), options, proofs), {}};
  report.results = requirement_results(report.analysis);
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report;
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
  return std::all_of(specs.begin(), specs.end(), [](const SpecCheck& s) { return s.all_met(); });
}

std::string verdict(const Requirement& r, const RequirementResult& result) {
  const std::string required =
      std::string(r.at_least ? "at least " : "at most ") + readable(r.limit, r.unit) + " is required";
  if (!result.proven) return r.name() + " is " + readable(result.value, r.unit) + ", " + required;
  return r.name() + " lies between " + readable(result.proven->lower, r.unit) + ", which is reached, and " +
         readable(result.proven->upper, r.unit) + ", " + required +
         (result.undecided ? ": not proven; " : "") + (result.undecided ? std::string(undecided_remedy) : "");
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
