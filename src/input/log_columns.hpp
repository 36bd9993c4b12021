#pragma once

#include <vector>

#include "input/log_table.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The columns of a log that qerr reads, in the order of the file.
struct LogColumns {
  std::vector<LogColumn> columns;
  std::vector<std::size_t> places;    ///< index of each column in the file
  std::vector<std::string> misspelt;  ///< see Log
};

/// Finds the columns by their names in the header; adds a warning about all other columns.
/// @throws Error (input) like LogReader for headers
LogColumns find_log_columns(const LogTable&, const Spec&, std::vector<std::string>& warnings);

/// A column of a log by its header, with the unit in which it is read.
/// @throws Error (input) for a unit that the signal cannot have
LogColumn column_of(const LogHeader&, LogSignal, std::size_t index, const Chain&);

/// The unit of a column of time stamps, seconds for "".
/// @throws Error (input) if it is no unit of time
Unit time_unit(const std::string& unit, const std::string& header, const Place&);

/// The signals that a log of this robot can have, such as `elbow.counts`.
std::vector<std::string> log_signal_names(const Chain&);

/// @throws Error (input) for a name that is none of them
void require_log_signal(const std::string& name, const Place&, const std::string& path, const Chain&);

}  // namespace qerr
