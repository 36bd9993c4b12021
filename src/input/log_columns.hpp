#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/log_table.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A mapping that a user is asked about, and can paste.
struct MappingProposal {
  LogReading reading;
  std::vector<std::string> left_out;  ///< columns that look like signals, each with what is not known of it
};

/// A mapping of the columns of a log whose names say little: guessed by names (of joints, or their numbers;
/// words for quantities), units and first values. The mapping of the spec and columns that are called as
/// signals are kept.
/// @pre no row of the log has been read
/// @returns no columns if it finds no measured joint
MappingProposal proposed_mapping(const LogTable&, const Spec&);

/// The header of a column that may be the time of a log without one: it rises in equal steps, and its name
/// says nothing else; "" if there is none.
std::string likely_time(const LogTable&, const Spec&);

/// A mapping as options of the command line and, behind them, as a section `log:` of a spec: lines to paste.
std::string mapping_text(const MappingProposal&);

enum class ColumnRole { none, other, position, counts, velocity, effort, command, temperature, tip };

/// A column of the log, as far as it is understood.
struct GuessedColumn {
  std::size_t index = 0;
  std::string name, unit;  ///< of the header
  std::vector<std::string> words;
  std::vector<double> values;
  ColumnRole role = ColumnRole::none;
  std::optional<std::size_t> joint;  ///< of a tip: the coordinate
  int side = 0;                      ///< > 0: of the load; > 1: of a sensor beside the robot
  std::string unknown_unit;          ///< of the header

  bool whole() const;
  double largest() const;
  /// The smallest step between neighbours: that of a quantized column; 0 of one that rests.
  double smallest_step() const;
};

/// Words and numbers of a name, in lower case: `actualQ_0` is actual, q, 0.
std::vector<std::string> words_in(const std::string& name);

/// Whether a word is one of those in a text, which has a blank before and behind each.
bool has_word(std::string_view words, const std::string& word);

/// What a column is by the words of its name, in English, German or French.
ColumnRole role_of(const std::vector<std::string>& words);

/// Whether a word says what a column is, or on which side of the gear it is.
bool is_known_word(const std::string& word);
/// -1 for a word of the motor's side, 1 for one of the load's, 2 for one of a sensor beside the robot.
int side_of(const std::string& word);
/// Whether it is of a sensor beside the robot.
bool is_of_sensor(const std::string& word);

/// The numbers among the first cells of a column, dates and times as seconds.
std::vector<double> numbers_of(const std::vector<std::string>& texts);

/// Correlation coefficient of two columns of one table; 0 if one of them rests, or has gaps.
double correlation_of(const std::vector<double>& x, const std::vector<double>& y);

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
