#pragma once

#include <optional>
#include <string>

/// Cells of CSV as RFC 4180 has them; a row ends with "\r\n".
namespace qerr {

/// The text with hidden characters escaped (core/text.hpp), quoted where it would be read otherwise. A text
/// that a spreadsheet would take for a formula, and that is no quantity such as `-5 deg`, starts with an
/// apostrophe, which column_name (input/csv.hpp) removes.
std::string csv_cell(const std::string& text);

/// The shortest digits that read back as the same double; empty if it is not finite or not known, which
/// plotting tools read as missing.
std::string csv_number(double value);
std::string csv_number(const std::optional<double>& value);

}  // namespace qerr
