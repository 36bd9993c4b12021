#include "csv.hpp"

#include <algorithm>

#include "qerr/core/quantity.hpp"
#include "qerr/core/suggest.hpp"
#include "qerr/core/text.hpp"
#include "qerr/input/read_text.hpp"

namespace qerr {

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Cells of one line; quotes protect commas, a doubled quote stands for one.
std::vector<std::string> cells_of(const std::string& line, const Place& place) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  if (quoted) throw Error({place, "", "a quote is not closed on its line", "", "end the cell with \""});
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

}  // namespace

ColumnName column_name(const std::string& cell) {
  const std::size_t open = cell.rfind('[');
  if (open == std::string::npos || !cell.ends_with(']')) return {cell, {}};
  return {trimmed(cell.substr(0, open)), trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

CsvTable read_csv_table(const std::string& path) {
  const std::string text = read_text(path);
  CsvTable table;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = trimmed(text.substr(at, end - at));
    at = end + 1;
    ++number;
    const Place place{path, number, 1};
    if (line.empty() || (table.header.empty() && line.front() == '#')) continue;
    const std::vector<std::string> cells = cells_of(line, place);
    if (table.header.empty()) {
      table.header = cells;
      continue;
    }
    if (cells.size() != table.header.size())
      throw Error({place, "", "the row has not as many cells as the header", counted(cells.size(), "cell"),
                   counted(table.header.size(), "cell")});
    std::vector<double>& row = table.rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto value = parse_number(cells[i]);
      if (!value)
        throw Error({place, table.header[i], "not a finite decimal number", "'" + cells[i] + "'",
                     "write a plain number"});
      row.push_back(*value);
    }
    table.lines.push_back(number);
  }
  if (table.rows.empty())
    throw Error({{path, std::max(number, 1), 1},
                 "",
                 "the file has no rows of numbers",
                 "",
                 "a header and at least one row"});
  return table;
}

}  // namespace qerr
