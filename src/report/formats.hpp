#pragma once

#include <array>

#include "qerr/report/analysis.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/plan_report.hpp"
#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"

/// The output formats: one row each, and one writer for every report.
///
/// To add a format: a row in `exporters`, its writer's name beside the others below, and one file per report
/// (report/analysis/FORMAT.cpp, report/check/FORMAT.cpp, ...).
namespace qerr {

template <class Report>
using Writer = std::string(const Report&, const Style&);

Writer<Analysis> to_table, to_json, to_csv;
Writer<CheckReport> to_table, to_json, to_csv;
Writer<ThresholdReport> to_table, to_json, to_csv;
Writer<FilterReport> to_table, to_json, to_csv;
Writer<SimulationReport> to_table, to_json, to_csv;
Writer<DiagnosisReport> to_table, to_json, to_csv;
Writer<PlanReport> to_table, to_json, to_csv;
Writer<ListReport> to_table, to_json, to_csv;

template <class Report>
struct Exporter {
  Format format;
  Writer<Report>* write;
};

/// The first row is the format of an output whose ending is not listed.
template <class Report>
inline constexpr std::array<Exporter<Report>, 3> exporters{{
    {{"table", ".txt", "for reading on a terminal"}, to_table},
    {{"json", ".json", "everything, SI units"}, to_json},
    {{"csv", ".csv", "one figure a row, RFC 4180, SI units"}, to_csv},
}};

}  // namespace qerr
