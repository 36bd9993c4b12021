#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/csv.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The unit that a word of a log's header means, as qerr writes it: `degrees`, `°`, `Grad` are `deg`, `msec`
/// is `ms`, `ticks` are `count`; "" if it is none.
std::string unit_in_words(std::string_view word);

/// The parts of a log's header cell, whose unit may be in brackets, in parentheses, behind a slash, a comma,
/// a word or an underscore, and in other words: `angle (degrees)`, `Zeit / s`, `t_ms`, `Winkel in Grad`.
ColumnName measured_name(const std::string& cell);

/// Whether a name, without its unit, means the time stamps: `Time`, `timestamp`, `Zeit`, `__time`.
bool is_time_name(std::string_view name);

/// What a column of a log's file is by its name, or by the mapping of columns.
struct ColumnMeaning {
  std::string signal;   ///< `time`, `a1.counts`; of an unknown column its name
  std::string unit;     ///< "" without one
  bool mapped = false;  ///< by the mapping
};

std::vector<ColumnMeaning> column_meanings(const std::vector<std::string>& header, const LogReading&);

/// Index of the time stamps: the column that the mapping names, else `time`, else the only one with a name
/// like it; empty if there is none.
std::optional<std::size_t> time_column(const std::vector<ColumnMeaning>&);

/// The unit of stamps that a program writes without it, told by its other columns: logs of libfranka are in
/// ms;
/// "" for others.
std::string program_time_unit(const std::vector<std::string>& header);

/// Adds `SIGNAL=COLUMN` or `SIGNAL=COLUMN [UNIT]`, as of --column, to the mapping of a spec, in place of what
/// it has for this signal.
/// @throws Error (usage) for another text, or a signal that no log of this robot has
void map_column(const std::string& assignment, Spec&);

}  // namespace qerr
