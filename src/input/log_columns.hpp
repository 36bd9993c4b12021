#pragma once

#include <vector>

#include "input/csv.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The columns of a log that mean something, in the file's order.
struct LogColumns {
  std::vector<LogColumn> columns;
  std::vector<std::size_t> places;  ///< of each: its number in the file
};

/// Finds them by the table's header and puts what is to be said of the others into `warnings`.
/// @throws Error (input) as LogReader does for headers
LogColumns find_log_columns(const CsvReader&, const Spec&, std::vector<std::string>& warnings);

}  // namespace qerr
