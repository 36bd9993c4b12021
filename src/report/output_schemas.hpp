#pragma once

#include "qerr/report/write.hpp"
#include "report/rows.hpp"

/// The rows of every report, each beside its other formats (report/analysis/json.cpp, ...). A command that is
/// not listed here is one whose report has no rows.
namespace qerr {

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
