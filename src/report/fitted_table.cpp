#include "report/fitted_table.hpp"

#include <algorithm>
#include <numeric>

#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

using TableCells = std::vector<std::vector<std::string>>;

constexpr std::size_t column_gap = 2;  // between columns

struct TableColumn {
  std::size_t width;  ///< as shown
  std::size_t least;  ///< of the cells and of the longest word of the header
};

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& word : wrapped_lines(text, 1)) longest = std::max(longest, display_width(word));
  return longest;
}

std::vector<TableColumn> columns_of(const TableCells& rows) {
  std::vector<TableColumn> columns;
  for (std::size_t i = 0; i < rows.front().size(); ++i) {
    std::size_t body = 0;
    for (std::size_t r = 1; r < rows.size(); ++r)
      if (i < rows[r].size()) body = std::max(body, display_width(rows[r][i]));
    const std::string& title = rows.front()[i];
    columns.push_back({std::max(body, display_width(title)), std::max(body, longest_word(title))});
  }
  return columns;
}

std::size_t total(const std::vector<TableColumn>& columns) {
  return std::accumulate(columns.begin(), columns.end(), column_gap * (columns.size() - 1),
                         [](std::size_t sum, const TableColumn& c) { return sum + c.width; });
}

/// Makes the columns with the longest headers narrower until the table fits, as far as words allow.
void stack_headers(std::vector<TableColumn>& columns, std::size_t room) {
  while (total(columns) > room) {
    const auto most = std::max_element(
        columns.begin(), columns.end(),
        [](const TableColumn& a, const TableColumn& b) { return a.width - a.least < b.width - b.least; });
    if (most->width == most->least) return;
    --most->width;
  }
}

TableCells with_stacked_header(const TableCells& rows, const std::vector<TableColumn>& columns) {
  std::vector<std::vector<std::string>> titles;
  std::size_t height = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    titles.push_back(wrapped_lines(rows.front()[i], columns[i].width));
    height = std::max(height, titles.back().size());
  }
  TableCells out;
  for (std::size_t k = 0; k < height; ++k) {
    out.emplace_back();
    for (const auto& title : titles) {
      const std::size_t missing = height - title.size();  // titles stand directly above their columns
      out.back().push_back(k < missing ? "" : title[k - missing]);
    }
  }
  out.insert(out.end(), rows.begin() + 1, rows.end());
  return out;
}

/// The first column and `count` others from `first` on.
TableCells part_of(const TableCells& rows, std::size_t first, std::size_t count) {
  TableCells part;
  for (const auto& row : rows) {
    part.push_back({row.front()});
    for (std::size_t i = first; i < std::min(first + count, row.size()); ++i) part.back().push_back(row[i]);
  }
  return part;
}

/// How many columns from `first` on fit beside the first one, with stacked headers; at least one.
std::size_t fitting(const std::vector<TableColumn>& columns, std::size_t first, std::size_t room) {
  std::size_t used = columns.front().least, count = 0;
  for (std::size_t i = first; i < columns.size(); ++i, ++count) {
    used += column_gap + columns[i].least;
    if (used > room && count > 0) break;
  }
  return count;
}

}  // namespace

std::string fitted_table(const TableCells& rows, std::size_t width, const std::string& indent) {
  if (rows.empty() || rows.front().size() < 2) return aligned(rows, indent);
  const std::size_t room = width > indent.size() ? width - indent.size() : 1;
  const std::vector<TableColumn> all = columns_of(rows);
  std::string out;
  for (std::size_t first = 1; first < all.size();) {
    const std::size_t count = fitting(all, first, room);
    const TableCells part = part_of(rows, first, count);
    std::vector<TableColumn> columns = columns_of(part);
    stack_headers(columns, room);
    out += (out.empty() ? "" : "\n") + aligned(with_stacked_header(part, columns), indent);
    first += count;
  }
  return out;
}

}  // namespace qerr
