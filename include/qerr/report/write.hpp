#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/design/threshold.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

/// A row of the list of output formats.
struct Format {
  std::string_view name;
  std::string_view ending;  ///< of a file that is in this format, with its dot
  std::string_view summary;
};

const std::vector<Format>& formats();

/// How a table may look.
struct Style {
  bool color = false;  ///< ANSI colours
};

/// The version of qerr that stands in every report.
std::string_view version();

/// @param format  a name of formats()
std::string write(const Analysis&, std::string_view format, const Style& = {});

/// `check`: the requirements of an analysis held against its figures.
std::string write_check(const Analysis&, std::string_view format, const Style& = {});
bool all_met(const Analysis&);

/// JUnit XML: one test case per requirement, value and limit in the failure message.
std::string junit(const Analysis&);

/// Table IV.
std::string write(const std::vector<ThresholdRow>&, std::string_view format, const Style& = {});

/// `qerr list KIND`: rows of a family. @returns "" for an unknown kind; `kinds` lists the known ones
std::string write_list(std::string_view kind, std::string_view format);
const std::vector<std::string>& list_kinds();

/// The JSON Schema (draft 7) of the spec.
std::string json_schema();

/// One CSV cell, quoted where RFC 4180 asks for it.
std::string csv_cell(const std::string&);

/// Header of the per-configuration CSV, and the row of one configuration.
/// @param spec  its model as the errors were computed with, effects included (`effect_report`)
/// @param noise  of `noise_in_motion`
std::string per_configuration_header(const Spec& spec, const std::vector<Eigen::VectorXd>& noise);
std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch&);

}  // namespace qerr
