#include "report/analysis/figure_names.hpp"
#include "report/analysis/json_header.hpp"

namespace qerr {

namespace {

using Result = In<RequirementResult, SpecCheck>;

Requirement requirement(const Result& r) {
  const Spec& spec = r.whole.analysis.spec;
  Requirement of = spec.requirements[r.i];
  if (of.limits_error()) of.unit = name_of(spec, of).unit;
  return of;
}

std::optional<ReportedProof> proof(const Result& r) {
  return r->proven ? std::optional(ReportedProof{*r->proven, r.whole.analysis.spec}) : std::nullopt;
}

std::string required(const JudgedRequirement& r) { return r.figure.name(); }

using Regression = In<FigureChange, BaselineCheck>;

}  // namespace

RowsOf<Result> rows(Of<Result>) {
  return requirement_rows<Result>(requirement, "absent for a figure of a filter", "either this or at_least",
                                  "")
      .with({{"proven", proof, "of the statistic proven_max", optional}});
}

RowsOf<BaselineCheck> rows(Of<BaselineCheck>) {
  return {{"file", &BaselineCheck::file},
          {"tolerance", &BaselineCheck::tolerance, "relative"},
          {"compared", &BaselineCheck::compared, "figures that both have"},
          {"missing", [](auto& b) { return b.missing | std::views::transform(&NamedFigure::name); },
           "figures that only the baseline has"},
          {"dropped_requirements",
           [](auto& b) { return b.dropped_requirements | std::views::transform(required); },
           "that only the baseline has"},
          {"not_in_baseline",
           [](auto& b) { return b.not_in_baseline | std::views::transform(&NamedFigure::name); },
           "required figures that it lacks"}};
}

RowsOf<Regression> rows(Of<Regression>) {
  return {{"quantity", [](auto& c) { return c->figure.quantity; }},
          {"statistic", [](auto& c) { return c->figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& c) { return c->figure.unit; }},
          {"baseline", &FigureChange::a, "null: unbounded"},
          {"value", &FigureChange::b, "null: unbounded"},
          {"change", &FigureChange::relative, "relative; null: from zero, or to unbounded", nullable}};
}

RowsOf<SpecCheck> rows(Of<SpecCheck>) {
  return analysis_header<SpecCheck>("check", [](const SpecCheck& c) -> const Analysis& { return c.analysis; })
      .with({{"requirements", within(&SpecCheck::results)},
             {"baseline", &SpecCheck::baseline, "with --baseline", optional},
             {"regressions",
              [](auto& c) {
                const auto regressions = within(&BaselineCheck::regressions);
                return c.baseline ? std::optional(regressions(*c.baseline)) : std::nullopt;
              },
              "with --baseline: figures that are worse", optional},
             {"met", &SpecCheck::all_met, "all requirements, and no figure is worse"},
             {"warnings", [](auto& c) { return c.analysis.warnings; }}});
}

RowsOf<BrokenSpec> rows(Of<BrokenSpec>) {
  return {{"file", &BrokenSpec::file}, {"error", [](auto& b) { return b.error.what(); }}};
}

RowsOf<CheckReport> rows(Of<CheckReport>) {
  return header<CheckReport>("check").with(
      {{"reports", &CheckReport::specs, "one for each spec, if there are several"},
       {"broken", &CheckReport::broken, "specs that cannot be checked"},
       {"met", &CheckReport::all_met, "all of all"}});
}

}  // namespace qerr
