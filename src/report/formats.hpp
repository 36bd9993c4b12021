#pragma once

#include <string>
#include <string_view>

#include "qerr/report/analysis.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/design_report.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/robot_report.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"
#include "report/page/page.hpp"

/// The writers of every report, one per format.
///
/// `html` is offered where a report has a page (page_of); the others are refused.
///
/// To add a format: a row in `exporters` (formats.cpp), its writer's name beside the others below, and one
/// file per report (report/analysis/FORMAT.cpp, report/check/FORMAT.cpp, ...).
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
Writer<CheckReport> to_table, to_csv;
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

}  // namespace qerr
