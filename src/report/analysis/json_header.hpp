#pragma once

#include "qerr/report/analysis.hpp"
#include "report/json_header.hpp"

/// What the JSON of an analysis shares with that of a check, of a sweep and of a design.
namespace qerr {

/// `qerr`, `command`, `spec`, `seed`, `robot`, `configurations`. @param of  the analysis of a report
template <class Report, class AnalysisOf>
RowsOf<Report> analysis_header(std::string_view command, AnalysisOf of) {
  return spec_header<Report>(command, [of](const Report& r) -> const Spec& { return of(r).spec; })
      .with({{"configurations",
              {{"method", [of](auto& r) { return method_name(of(r).spec); }},
               {"count", [of](auto& r) { return of(r).workspace.count; }}}}});
}
std::string_view method_name(const Spec&);

/// Each encoder's share of the variance of the tip.
std::vector<std::pair<std::string, double>> budget(const Analysis&);

/// A proven maximum; null is unbounded.
struct ReportedProof : ProvenMaximum {
  const Spec& spec;
};
RowsOf<ReportedProof> rows(Of<ReportedProof>);

/// The result of a requirement, which a getter returns. @param statistic, limit, value  meanings of members
template <class Result, class RequirementOf>
RowsOf<Result> requirement_rows(RequirementOf of, std::string_view statistic, std::string_view limit,
                                std::string_view value) {
  return {{"quantity", [of](auto& r) { return of(r).quantity; }},
          {"statistic", [of](auto& r) { return of(r).statistic; }, statistic, optional},
          {"at_most", [of](auto& r) { return only_if(!of(r).at_least, of(r).limit); }, limit, optional},
          {"at_least", [of](auto& r) { return only_if(of(r).at_least, of(r).limit); }, optional},
          {"value", &RequirementResult::value, value, nullable},
          {"unit", [of](auto& r) { return of(r).unit; }},
          {"met", &RequirementResult::met}};
}

}  // namespace qerr
