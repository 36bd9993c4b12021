#pragma once

#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/write.hpp"
#include "report/rows.hpp"

namespace qerr {

/// What the JSON of several reports begins with.

/// The spec of a report: its file, the file's hash, and the values that the command line replaced.
RowsOf<Spec> rows(Of<Spec>);

RowsOf<Interval> rows(Of<Interval>);

/// The rows of a matrix.
std::vector<std::vector<double>> nested(const Eigen::MatrixXd&);
/// Values of the independent joints by their names.
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

struct SpecCheck;

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

}  // namespace qerr
