#include "report/wrapped_text.hpp"

#include <algorithm>
#include <numeric>

#include "core/text.hpp"

namespace qerr {

namespace {

constexpr std::size_t cell_gap = 2;      // between columns
constexpr std::size_t least_column = 8;  // a narrower one cuts ordinary words

/// Columns of a text without the codes of its colours.
std::size_t shown_width(const std::string& text) {
  std::size_t width = display_width(text);
  for (std::size_t at = 0; (at = text.find("\x1b[", at)) != std::string::npos;) {
    const std::size_t end = text.find('m', at);
    if (end == std::string::npos) break;
    width -= end + 1 - at;
    at = end;
  }
  return width;
}

std::size_t room_behind(std::size_t width, const std::string& indent) {
  const std::size_t used = display_width(indent);
  return width > used ? width - used : 1;
}

std::vector<std::size_t> column_widths(const std::vector<std::vector<std::string>>& rows, std::size_t room) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (widths.size() <= i) widths.push_back(0);
      widths[i] = std::max(widths[i], display_width(row[i]));
    }
  const std::size_t gaps = widths.empty() ? 0 : cell_gap * (widths.size() - 1);
  while (std::accumulate(widths.begin(), widths.end(), gaps) > room) {
    const auto widest = std::max_element(widths.begin(), widths.end());
    if (*widest <= least_column) break;
    --*widest;
  }
  return widths;
}

}  // namespace

std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width) {
  return wrapped_lines(text, width, width);
}

std::string wrapped(std::string_view text, std::size_t width, const std::string& indent) {
  return wrapped(text, width, indent, indent);
}

std::string within(const std::string& text, std::size_t width) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin == std::string::npos || shown_width(line) <= width)
      out += line + '\n';
    else
      out += wrapped(line.substr(begin), width, std::string(begin + 2, ' '), std::string(begin, ' '));
  }
  return out;
}

std::string defined(const std::string& term, std::string_view meaning, std::size_t width,
                    std::size_t column) {
  const std::string indent(column, ' ');
  const std::string start = "  " + term;
  if (display_width(start) + cell_gap > column) return start + '\n' + wrapped(meaning, width, indent);
  return wrapped(meaning, width, indent, start + std::string(column - display_width(start), ' '));
}

std::string wrapped_table(const std::vector<std::vector<std::string>>& rows, std::size_t width,
                          const std::string& indent) {
  const std::vector<std::size_t> widths = column_widths(rows, room_behind(width, indent));
  std::string out;
  for (const auto& row : rows) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      cells.push_back(wrapped_lines(row[i], widths[i]));
      height = std::max(height, cells.back().size());
    }
    for (std::size_t k = 0; k < height; ++k) {
      std::string line = indent;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::string part = k < cells[i].size() ? cells[i][k] : "";
        const std::size_t used = display_width(part);
        line += (i ? std::string(cell_gap, ' ') : "") + part +
                std::string(widths[i] > used ? widths[i] - used : 0, ' ');
      }
      line.erase(line.find_last_not_of(' ') + 1);
      out += line + '\n';
    }
  }
  return out;
}

}  // namespace qerr
