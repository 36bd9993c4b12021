#pragma once

#include <vector>

#include "input/csv.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The columns of a log that qerr reads, in the order of the file.
struct LogColumns {
  std::vector<LogColumn> columns;
  std::vector<std::size_t> places;  ///< index of each column in the file
};

/// Finds the columns by their names in the header; adds a warning about all other columns.
/// @throws Error (input) like LogReader for headers
LogColumns find_log_columns(const CsvReader&, const Spec&, std::vector<std::string>& warnings);

}  // namespace qerr
