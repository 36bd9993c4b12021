#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qerr/core/parameter.hpp"

namespace qerr {

struct Analysis;
struct CheckReport;
struct ReportComparison;
struct DesignReport;
struct ThresholdReport;
struct FilterReport;
struct SimulationReport;
struct DiagnosisReport;
struct PlanReport;
struct RobotReport;
struct ListReport;

/// A row of the list of output formats.
struct Format {
  std::string_view name;
  std::string_view ending;  ///< of a file in this format, with its dot
  std::string_view summary;
};

const std::vector<Format>& formats();

/// Name of the format of a file with this path, by its ending; the first format if no ending is known.
std::string_view format_of(std::string_view path);

/// Appearance of a table.
struct Style {
  bool color = false;      ///< ANSI colours
  bool details = false;    ///< everything, in place of a summary
  bool ascii = false;      ///< pictures in ASCII characters
  std::size_t width = 80;  ///< columns of the terminal: no line of a table is wider where it can be broken
};

/// One of the reports above as text.
/// @param format  name of a row of formats()
/// @throws Error (usage) for an unknown format
template <class Report>
std::string write(const Report&, std::string_view format, const Style& = {});

/// The result of `qerr list KIND`: the members of one family.
struct ListReport {
  struct Row {
    std::string name;
    std::string summary;
    std::vector<Parameter> parameters = {};
    /// Name and text of further columns; every row has the same names.
    std::vector<std::pair<std::string, std::string>> notes = {};
  };
  std::vector<Row> rows;
};

/// The families that can be listed: effects, filters, encoders, formats, coordinates, statistics.
const std::vector<std::string>& list_kinds();

/// The rows of one of `list_kinds()`. @returns no rows for another name
ListReport list_report(std::string_view kind);

/// The JSON Schema (draft 7) of the spec.
std::string json_schema();

/// The names of the reports with a JSON form: of a command, and `plan` of `diagnose --plan`.
std::vector<std::string> output_schema_names();

/// The JSON Schema (draft 2020-12) of a report in JSON. @pre the name is one of output_schema_names()
std::string output_schema(std::string_view report);

/// The version of qerr, which is part of every report.
std::string_view version();

}  // namespace qerr
