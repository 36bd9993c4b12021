#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "report/rows.hpp"

/// Cells of CSV as RFC 4180 has them; a row ends with "\r\n".
namespace qerr {

/// The text with hidden characters escaped (core/text.hpp), quoted where it would be read otherwise. A text
/// that a spreadsheet would take for a formula, and that is no quantity such as `-5 deg`, starts with an
/// apostrophe, which column_name (input/csv.hpp) removes.
std::string csv_cell(const std::string& text);

/// The shortest digits that read back as the same double; `inf` of what is unbounded; empty, which plotting
/// tools read as missing, of what is not known.
std::string csv_number(double value);
std::string csv_number(const std::optional<double>& value);

/// Cells of an object's members; a path such as `limits.lower` names those of an object in it. Empty:
/// missing.
std::string csv_cells(const Json& object, const std::vector<std::string>& paths);

/// The paths of all members that are no objects. @param schema  of an object
std::vector<std::string> csv_paths(const Json& schema);

/// One row for each item, with a column for each of its members but those `without`.
template <class T>
std::string csv_of(const std::vector<T>& items, const std::set<std::string>& without = {}) {
  std::vector<std::string> paths = csv_paths(schema_of<T>());
  std::erase_if(paths, [&](const std::string& path) { return without.contains(path); });
  std::string out;
  for (const std::string& path : paths) out += (out.empty() ? "" : ",") + path.substr(path.rfind('.') + 1);
  for (const T& item : items) out += "\r\n" + csv_cells(json_of(item), paths);
  return out + "\r\n";
}

}  // namespace qerr
