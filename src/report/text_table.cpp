#include "report/text_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "qerr/core/error.hpp"

namespace qerr {

namespace {

constexpr std::size_t column_gap = 2;
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

std::vector<std::size_t> column_widths(const TableRows& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (widths.size() <= i) widths.push_back(0);
      widths[i] = std::max(widths[i], display_width(row[i]));
    }
  return widths;
}

/// The widest columns give way until the table fits.
std::vector<std::size_t> fitting_widths(const TableRows& rows, std::size_t room) {
  std::vector<std::size_t> widths = column_widths(rows);
  const std::size_t gaps = widths.empty() ? 0 : column_gap * (widths.size() - 1);
  while (std::accumulate(widths.begin(), widths.end(), gaps) > room) {
    const auto widest = std::ranges::max_element(widths);
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
  for (const std::string& line : lines_of(text)) {
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
  if (display_width(start) + column_gap > column) return start + '\n' + wrapped(meaning, width, indent);
  return wrapped(meaning, width, indent, start + std::string(column - display_width(start), ' '));
}

std::string wrapped_table(const TableRows& rows, std::size_t width, const std::string& indent) {
  const std::vector<std::size_t> widths = fitting_widths(rows, room_behind(width, indent));
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
        line += (i ? std::string(column_gap, ' ') : "") + part +
                std::string(widths[i] > used ? widths[i] - used : 0, ' ');
      }
      line.erase(line.find_last_not_of(' ') + 1);
      out += line + '\n';
    }
  }
  return out;
}

std::vector<std::string> aligned_lines(const TableRows& rows, const std::string& indent) {
  const std::vector<std::size_t> width = column_widths(rows);
  std::vector<std::string> lines;
  for (const auto& row : rows) {
    std::string& line = lines.emplace_back(indent);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string gap(width[i] - display_width(row[i]), ' ');
      line += (i ? "  " : "") + (i ? gap + row[i] : row[i] + gap);
    }
    line.erase(line.find_last_not_of(' ') + 1);
  }
  return lines;
}

std::string aligned(const TableRows& rows, const std::string& indent) {
  std::string out;
  for (const std::string& line : aligned_lines(rows, indent)) out += line + '\n';
  return out;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

std::string percent(double fraction) {
  if (std::isnan(fraction)) return "";
  const double value = 100 * std::abs(fraction);
  const std::string sign = fraction < 0 ? "-" : "";
  if (value > 10000) return sign.empty() ? ">10000 %" : "<-10000 %";
  if (value > 0 && value < 0.001) return "<0.001 %";
  // From 1000 on significant() would write an exponent.
  return sign + (value >= 999.5 ? fixed_point(value, 0) : significant(value, 3)) + " %";
}

std::string bar(double fraction, int width) {
  static constexpr std::array<const char*, 8> eighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int cells = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * width * 8));
  std::string text;
  for (int i = 0; i < cells / 8; ++i) text += "█";
  return text + eighths[cells % 8];
}

std::string painted(const std::string& text, Paint paint, const Style& style) {
  static constexpr std::array<const char*, 4> codes{"1", "1;31", "1;32", "1;33"};
  if (!style.color) return text;
  return "\x1b[" + std::string(codes[static_cast<std::size_t>(paint)]) + 'm' + text + "\x1b[0m";
}

std::string heading(const std::string& text, const Style& style) {
  std::string out = "\n";
  for (const std::string& line : wrapped_lines(text, style.width))
    out += painted(line, Paint::bold, style) + '\n';
  return out;
}

std::string shortened(const std::string& name, std::size_t width) {
  const std::string text = escaped(name, 4096);
  if (display_width(text) <= width) return text;
  std::vector<std::string> letters;  // of one or more bytes
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0u) != 0x80u) letters.emplace_back();
    letters.back() += c;
  }
  const std::size_t kept = width - 2, front = kept / 2, back = kept - front;
  std::string out;
  for (std::size_t i = 0; i < front; ++i) out += letters[i];
  out += "..";
  for (std::size_t i = letters.size() - back; i < letters.size(); ++i) out += letters[i];
  return out;
}

std::string shown(const std::string& name) { return escaped(name, 60); }

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

void add_to_group(ItemGroups& groups, const std::string& name, const std::string& item) {
  auto group = std::ranges::find_if(groups, [&](const auto& g) { return g.first == name; });
  if (group == groups.end()) group = groups.insert(group, {name, {}});
  add_once(group->second, item);
}

namespace {

struct TableColumn {
  std::size_t width;  ///< as shown
  std::size_t least;  ///< of the cells and of the longest word of the header
};

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& word : wrapped_lines(text, 1)) longest = std::max(longest, display_width(word));
  return longest;
}

std::vector<TableColumn> columns_of(const TableRows& rows) {
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
    const auto most = std::ranges::max_element(columns, [](const TableColumn& a, const TableColumn& b) {
      return a.width - a.least < b.width - b.least;
    });
    if (most->width == most->least) return;
    --most->width;
  }
}

TableRows with_stacked_header(const TableRows& rows, const std::vector<TableColumn>& columns) {
  std::vector<std::vector<std::string>> titles;
  std::size_t height = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    titles.push_back(wrapped_lines(rows.front()[i], columns[i].width));
    height = std::max(height, titles.back().size());
  }
  TableRows out;
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
TableRows part_of(const TableRows& rows, std::size_t first, std::size_t count) {
  TableRows part;
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

std::string fitted_table(const TableRows& rows, std::size_t width, const std::string& indent) {
  if (rows.empty() || rows.front().size() < 2) return aligned(rows, indent);
  const std::size_t room = room_behind(width, indent);
  const std::vector<TableColumn> all = columns_of(rows);
  std::string out;
  for (std::size_t first = 1; first < all.size();) {
    const std::size_t count = fitting(all, first, room);
    const TableRows part = part_of(rows, first, count);
    std::vector<TableColumn> columns = columns_of(part);
    stack_headers(columns, room);
    out += (out.empty() ? "" : "\n") + aligned(with_stacked_header(part, columns), indent);
    first += count;
  }
  return out;
}

std::string table_section(const std::string& title, const TableRows& rows, const Style& style,
                          const std::string& remark) {
  if (rows.size() < 2) return "";
  return heading(title, style) + fitted_table(rows, style.width) +
         (remark.empty() ? "" : wrapped(remark, style.width, "  "));
}

namespace {

constexpr int most_rows = 10;
constexpr std::size_t most_columns = 72;  // a wider picture shows no more of some fifty bins
constexpr std::size_t least_columns = 12;
constexpr double tick_distance = 8;  // columns between the ticks of the abscissa

struct Glyphs {
  const char *point, *line, *both, *rise, *axis, *tick, *corner, *across, *across_tick;
};
constexpr Glyphs unicode_glyphs{"•", "─", "●", "│", "│", "┤", "└", "─", "┬"};
constexpr Glyphs ascii_glyphs{"o", "-", "*", "|", "|", "+", "+", "-", "+"};

struct ValueRange {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

/// The ordinate of row k, counted from zero upwards, is k * tick / rows_per_tick.
struct Ordinate {
  double tick = 1;
  int rows_per_tick = 2;
  int lowest = 0, highest = 0;

  double per_row() const { return tick / rows_per_tick; }
  int row(double value) const { return static_cast<int>(std::lround(value / per_row())); }
};

/// The finest ordinate with a round tick every second to fifth row on which the range fits. Successive values
/// per row differ by a third at most, so that at least eight of the rows are used.
Ordinate ordinate(const ValueRange& range) {
  constexpr double round[] = {1, 2, 2.5, 5};
  const double least = (range.most - range.least) / most_rows;
  const double decade = std::pow(10, std::floor(std::log10(least)) - 1);
  Ordinate best;
  double finest = std::numeric_limits<double>::infinity();
  for (double power = decade; power < 1e4 * decade; power *= 10)
    for (const double digit : round)
      for (int rows = 2; rows <= 5; ++rows) {
        Ordinate o{digit * power, rows};
        o.lowest = o.row(range.least);
        o.highest = o.row(range.most);
        if (o.highest - o.lowest >= most_rows || !(o.per_row() < finest)) continue;
        finest = o.per_row();
        best = o;
      }
  return best;
}

/// Mean of the finite values of every column.
std::vector<double> column_means(const TextPicture& p, const std::vector<double>& values,
                                 std::size_t columns) {
  std::vector<double> sum(columns), count(columns);
  const double span = p.at.back() - p.at.front();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const auto column = static_cast<std::size_t>(
        std::lround((p.at[i] - p.at.front()) / span * static_cast<double>(columns - 1)));
    sum[column] += values[i];
    count[column] += 1;
  }
  for (std::size_t c = 0; c < columns; ++c) sum[c] = count[c] > 0 ? sum[c] / count[c] : std::nan("");
  return sum;
}

/// The line at every column: interpolated between finite neighbours in the list, NaN in a gap.
std::vector<double> interpolated(const TextPicture& p, std::size_t columns) {
  std::vector<double> values = column_means(p, p.line, columns);
  const double span = p.at.back() - p.at.front();
  std::size_t right = 1;
  for (std::size_t c = 0; c < columns; ++c) {
    const double at = p.at.front() + span * static_cast<double>(c) / static_cast<double>(columns - 1);
    while (right + 1 < p.at.size() && p.at[right] < at) ++right;
    const double length = p.at[right] - p.at[right - 1];
    if (!std::isfinite(values[c]) && right < p.line.size())
      values[c] = p.line[right - 1] +
                  (p.line[right] - p.line[right - 1]) * (length > 0 ? (at - p.at[right - 1]) / length : 0);
  }
  return values;
}

using Canvas = TableRows;  // rows from the lowest, of cells

void draw_line(Canvas& canvas, const std::vector<double>& values, const Ordinate& o, const Glyphs& glyphs) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!std::isfinite(values[c])) continue;
    const int row = o.row(values[c]) - o.lowest;
    canvas[row][c] = glyphs.line;
    if (c == 0 || !std::isfinite(values[c - 1])) continue;
    const int before = o.row(values[c - 1]) - o.lowest;
    for (int k = std::min(row, before) + 1; k < std::max(row, before); ++k) canvas[k][c] = glyphs.rise;
  }
}

void draw_points(Canvas& canvas, const std::vector<double>& values, const Ordinate& o, const Glyphs& glyphs) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!std::isfinite(values[c])) continue;
    std::string& cell = canvas[o.row(values[c]) - o.lowest][c];
    cell = cell == " " ? glyphs.point : glyphs.both;
  }
}

/// A multiple of a round tick; small sums of rounding errors are zero.
std::string tick_label(int multiple, double tick) { return significant(multiple * tick, 6); }

std::vector<std::string> row_labels(const Ordinate& o) {
  std::vector<std::string> labels;
  for (int k = o.lowest; k <= o.highest; ++k)
    labels.push_back(k % o.rows_per_tick == 0 ? tick_label(k / o.rows_per_tick, o.tick) : "");
  return labels;
}

/// The line below the rows, and its labels, without those that would touch another one.
std::pair<std::string, std::string> abscissa(const TextPicture& p, std::size_t columns,
                                             const Glyphs& glyphs) {
  const double from = p.at.front(), span = p.at.back() - from;
  const double tick = round_step(span * tick_distance / static_cast<double>(columns));
  std::vector<std::string> marks(columns, glyphs.across);
  std::string labels;
  for (double k = std::ceil(from / tick - 1e-9); k * tick <= p.at.back() + 1e-9 * tick; ++k) {
    const double place = (k * tick - from) / span * static_cast<double>(columns - 1);
    const auto column = std::min(columns - 1, static_cast<std::size_t>(std::lround(std::max(place, 0.0))));
    const std::string label = tick_label(static_cast<int>(k), tick);
    const std::size_t begin = column - std::min(column, label.size() / 2);
    marks[column] = glyphs.across_tick;
    if (begin < labels.size() + (labels.empty() ? 0 : 1) || begin + label.size() > columns + 1) continue;
    labels += std::string(begin - labels.size(), ' ') + label;
  }
  std::string line;
  for (const std::string& mark : marks) line += mark;
  return {line, labels};
}

std::string legend(const TextPicture& p, const Glyphs& glyphs) {
  std::string text = p.ordinate + " against " + p.abscissa + ": " + glyphs.point + " " + p.points_name;
  if (!p.line.empty())
    text += std::string(", ") + glyphs.line + " " + p.line_name + ", " + glyphs.both + " both";
  return text;
}

ValueRange range_of(const TextPicture& p) {
  ValueRange range;
  range.add(0);
  for (const double value : p.points) range.add(value);
  for (const double value : p.line) range.add(value);
  return range;
}

}  // namespace

double round_step(double least, double tolerance) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= least * (1 - tolerance)) return digit * power;
  return 10 * power;
}

std::string text_picture(const TextPicture& p, const Style& style, const std::string& indent) {
  const auto finite = std::ranges::count_if(p.points, [](double v) { return std::isfinite(v); });
  const ValueRange range = range_of(p);
  if (finite < 2 || !(p.at.back() > p.at.front()) || !(range.most > range.least)) return "";
  const Glyphs& glyphs = style.ascii ? ascii_glyphs : unicode_glyphs;
  const Ordinate o = ordinate(range);
  const std::vector<std::string> labels = row_labels(o);
  std::size_t margin = 0;
  for (const std::string& label : labels) margin = std::max(margin, label.size());
  const std::size_t used = indent.size() + margin + 2;  // a blank and the axis
  const std::size_t columns =
      std::min(most_columns, style.width > used + least_columns ? style.width - used : least_columns);
  Canvas canvas(labels.size(), std::vector<std::string>(columns, " "));
  draw_line(canvas, interpolated(p, columns), o, glyphs);
  draw_points(canvas, column_means(p, p.points, columns), o, glyphs);

  std::string out = wrapped(legend(p, glyphs), style.width, indent);
  for (std::size_t k = labels.size(); k-- > 0;) {
    std::string line = indent + std::string(margin - labels[k].size(), ' ') + labels[k] + ' ' +
                       (labels[k].empty() ? glyphs.axis : glyphs.tick);
    for (const std::string& cell : canvas[k]) line += cell;
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  const auto [line, names] = abscissa(p, columns, glyphs);
  const std::string below = indent + std::string(margin + 1, ' ');
  return out + below + glyphs.corner + line + '\n' + below + ' ' + names + '\n';
}

}  // namespace qerr
