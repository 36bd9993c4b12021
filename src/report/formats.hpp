#pragma once

#include <string>
#include <string_view>

#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/design_report.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/robot_report.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"
#include "report/page/page.hpp"
#include "report/rows.hpp"

/// Every report: its rows, from which JSON and schema follow, and its writers, one per format.
///
/// `html` is offered where a report has a page (page_of); the others are refused.
///
/// To add a format: a row in `exporters` (formats.cpp), its writer's name beside the others below, and its
/// writer in the file of each report (report/analysis, report/check/check_report.cpp,
/// report/design/formats.cpp, ...).
namespace qerr {

/// What the command line changed of a spec, which stands above every table; "" if nothing.
std::string changes_above(const Spec&, std::size_t width);

/// SI unit of a number, `rad or m` of a joint coordinate; "" for a pure number and for other kinds.
std::string parameter_unit(const Parameter&);

/// For commands whose report has no page, before the work that their report takes.
/// @throws Error (usage) for `html`
void refuse_page(std::string_view format);

template <class Report>
using Writer = std::string(const Report&, const Style&);

Writer<Analysis> to_table, to_csv;
Writer<CheckReport> to_table, to_csv, to_markdown;
Writer<ReportComparison> to_table, to_csv;
Writer<DesignReport> to_table, to_csv;
Writer<ThresholdReport> to_table, to_csv;
Writer<FilterReport> to_table, to_csv;
Writer<SimulationReport> to_table, to_csv;
Writer<DiagnosisReport> to_table, to_csv;
Writer<PlanReport> to_table, to_csv;
Writer<RobotReport> to_table, to_csv;
Writer<ListReport> to_table, to_csv;

/// Pages, to which the JSON of the report is added.
page::Page page_of(const Analysis&);
page::Page page_of(const CheckReport&);
page::Page page_of(const ReportComparison&);
page::Page page_of(const DesignReport&);
page::Page page_of(const FilterReport&);
page::Page page_of(const SimulationReport&);
page::Page page_of(const DiagnosisReport&);

/// What the JSON of several reports begins with.

/// The spec of a report: its file, the file's hash, and the values that the command line replaced.
RowsOf<Spec> rows(Of<Spec>);

RowsOf<Interval> rows(Of<Interval>);

std::vector<std::vector<double>> nested(const Eigen::MatrixXd&);
std::vector<std::pair<std::string, double>> by_joint(const Spec&, const Eigen::VectorXd& values);

/// `qerr`, `command`.
template <class Report>
RowsOf<Report> header(std::string_view command) {
  return {{"qerr", [](auto&) { return version(); }, "the version that wrote the report"},
          {"command", [command](auto&) { return command; }, constant(command)}};
}

/// `qerr`, `command`, `spec`, `seed`, `robot`.
/// @param spec_of  the spec of a report, by reference
template <class Report, class SpecOf>
RowsOf<Report> spec_header(std::string_view command, SpecOf spec_of) {
  return header<Report>(command).with(
      {{"spec", spec_of},
       {"seed",
        [spec_of](auto& r) {
          if constexpr (requires { r.seed; })
            return r.seed;
          else
            return spec_of(r).configurations.seed;
        }},
       {"robot",
        {{"name", [spec_of](auto& r) { return spec_of(r).robot_name; }},
         {"base", [spec_of](auto& r) { return spec_of(r).model.chain.base; }},
         {"tip", [spec_of](auto& r) { return tips_of(spec_of(r).model); }}}}});
}
template <class Report>
RowsOf<Report> spec_header(std::string_view command) {
  return spec_header<Report>(command, [](const Report& r) -> const Spec& { return r.spec; });
}

/// The rows of every report, each beside its other formats (report/analysis/json.cpp, ...). A command that is
/// not listed here is one whose report has no rows.

RowsOf<Analysis> rows(Of<Analysis>);
RowsOf<CheckReport> rows(Of<CheckReport>);  ///< of several specs
RowsOf<SpecCheck> rows(Of<SpecCheck>);
RowsOf<ReportComparison> rows(Of<ReportComparison>);
RowsOf<DesignReport> rows(Of<DesignReport>);
RowsOf<DiagnosisReport> rows(Of<DiagnosisReport>);
RowsOf<FilterReport> rows(Of<FilterReport>);
RowsOf<ListReport::Row> rows(Of<ListReport::Row>);
RowsOf<PlanReport> rows(Of<PlanReport>);
RowsOf<RobotReport> rows(Of<RobotReport>);
RowsOf<SimulationReport> rows(Of<SimulationReport>);
RowsOf<ThresholdReport> rows(Of<ThresholdReport>);

Json sweep_schema();

/// What the JSON of an analysis shares with that of a check, of a sweep and of a design.

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
