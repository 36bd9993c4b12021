#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/log_table.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_sampled = 200;  // lines that decide on a format: more cannot change it much

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

struct SampleLine {
  std::string_view text;
  std::size_t offset = 0;
  int number = 1;
  bool comment = false;
};

std::vector<SampleLine> lines_of(std::string_view head) {
  std::vector<SampleLine> lines;
  int number = 1;
  for (std::size_t at = 0; at < head.size() && lines.size() < most_sampled;) {
    const bool comment = head[at] == '#';
    const RecordEnd record = find_record_end(head.substr(at), ",;\t|");
    const bool by_line = comment || record.open != std::string_view::npos;
    const std::size_t end =
        by_line ? std::min(head.find('\n', at), head.size()) : std::min(record.at, head.size() - at) + at;
    const std::string_view text = head.substr(at, end - at);
    if (!trimmed(text).empty()) lines.push_back({text, at, number, comment});
    number += 1 + static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    at = end + 1;
  }
  // The last line of a sample may be cut off.
  if (lines.size() > 2 && lines.size() < most_sampled && !head.ends_with('\n')) lines.pop_back();
  return lines;
}

std::vector<std::string_view> cells_by(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  const auto separates = [&](char c) { return c == separator || (separator == ' ' && c == '\t'); };
  if (separator == ' ') line = trimmed(line);
  for (std::size_t at = 0;; ++at) {
    while (at < line.size() && is_blank(line[at]) && (separator == ' ' || !separates(line[at]))) ++at;
    std::size_t end = at;
    if (end < line.size() && line[end] == '"') end = std::min(line.find('"', at + 1), line.size() - 1) + 1;
    while (end < line.size() && !separates(line[end])) ++end;
    cells.push_back(without_text_mark(bare_cell(line.substr(at, end - at))));
    if (end >= line.size()) return cells;
    at = end;
  }
}

/// `2026-05-01T12:00:00.5Z`, `26.11.2026 17:16:42,123`, `14-Mar-2026 17:16:42`, `17:16:42`.
bool is_stamp(std::string_view written) {
  if (!is_decimal_digit(written.front())) return false;
  const std::string text = with_month_number(written);
  const auto marks = std::count_if(text.begin(), text.end(),
                                   [](char c) { return c == ':' || c == '-' || c == '/' || c == '.'; });
  return marks >= 2 && text.size() <= 40 && std::all_of(text.begin(), text.end(), [](char c) {
           return is_decimal_digit(c) ||
                  std::string_view(":-/. ,+TZtzAPMapm").find(c) != std::string_view::npos;
         });
}

/// `1.234,5`
bool has_thousands(std::string_view cell, char decimal) {
  std::string copy(cell);
  const auto mark = remove_thousands(copy);
  return mark && (*mark == '\0' || *mark == decimal);
}

/// What a line is by a separator and a decimal mark.
struct LineCells {
  std::size_t cells = 0, numbers = 0, texts = 0;
  bool is_data() const { return numbers > 0; }
};

/// @param with_units  whether `12.5 deg` is a number
LineCells counted_cells(std::string_view line, char separator, char decimal, bool with_units) {
  LineCells c;
  for (const std::string_view cell : cells_by(line, separator)) {
    ++c.cells;
    if (cell.empty()) continue;
    const bool number = is_numeric(cell, decimal) || is_stamp(cell) || has_thousands(cell, decimal) ||
                        (with_units && !number_and_unit(cell, decimal).unit.empty());
    ++(number ? c.numbers : c.texts);
  }
  return c;
}

/// A way to separate the cells of a table, and how well it does.
struct Separation {
  char separator, decimal;
  std::int64_t score = 0;
  std::size_t cells = 0;
};

/// Numbers minus texts in the lines of the most frequent width.
void rate(Separation& c, const std::vector<SampleLine>& lines, bool with_units) {
  struct Width {
    std::size_t rows = 0;
    std::int64_t score = 0;
  };
  std::map<std::size_t, Width> widths;
  for (const SampleLine& line : lines) {
    if (line.comment) continue;
    const LineCells cells = counted_cells(line.text, c.separator, c.decimal, with_units);
    if (!cells.is_data()) continue;
    Width& w = widths[cells.cells];
    ++w.rows;
    w.score += static_cast<std::int64_t>(cells.numbers) - static_cast<std::int64_t>(cells.texts);
  }
  std::size_t rows = 0;
  for (const auto& [width, w] : widths)
    if (w.rows > rows) rows = w.rows, c.score = w.score, c.cells = width;
}

bool is_unit_word(std::string_view cell) {
  if (cell.size() > 2 &&
      ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')))
    return true;
  std::string why;
  return cell.empty() || cell == "-" || parse_unit(cell, why).has_value() || !unit_in_words(cell).empty();
}

/// Cells of a header, without those that are the unit of the name before: `Angle, deg`.
std::size_t named_cells(std::string_view line, char separator) {
  const auto cells = cells_by(line, separator);
  return cells.size() -
         static_cast<std::size_t>(std::count_if(cells.begin() + 1, cells.end(), is_unit_behind_comma));
}

bool is_units_row(std::string_view line, char separator) {
  const auto cells = cells_by(line, separator);
  return std::all_of(cells.begin(), cells.end(), is_unit_word);
}

/// The key that every other cell repeats, `Name x Name y`; "" if there is none.
std::string_view repeated_key(std::string_view line, char separator) {
  const auto cells = cells_by(line, separator);
  if (cells.size() < 4 || cells[0].empty() || is_numeric(cells[0], '.')) return "";
  for (std::size_t i = 2; i < cells.size() - cells.size() % 2; i += 2)
    if (cells[i] != cells[0]) return "";
  return cells[0];
}

/// TwinCAT's Scope writes above the rows what each pair of columns is, a key before each word.
void find_keyed_header(TableFormat& f, const std::vector<SampleLine>& lines, std::size_t last) {
  std::size_t name = lines.size();
  for (std::size_t i = last + 1; i-- > 0;) {
    const std::string_view key = repeated_key(lines[i].text, f.separator);
    if (key.empty()) break;
    if (key == "Name" || (key == "SymbolName" && name == lines.size())) name = i;
  }
  if (name == lines.size()) return;
  f.keyed_until = lines[last].number;
  f.header = lines[name].offset;
  f.header_line = lines[name].number;
  f.has_units = false;
}

/// Finds the header among the lines, by the rows that follow it.
void find_header(TableFormat& f, const std::vector<SampleLine>& lines, bool with_units) {
  std::vector<LineCells> cells;
  for (const SampleLine& line : lines)
    cells.push_back(counted_cells(line.text, f.separator, f.decimal, with_units));
  const auto is_row = [&](std::size_t i) {
    return i < lines.size() && !lines[i].comment && cells[i].is_data();
  };
  const auto fits = [&](std::size_t i) {
    const std::size_t apart = std::max(cells[i].cells, f.cells) - std::min(cells[i].cells, f.cells);
    return apart == 0 || (apart == 1 && f.separator != ' ') || f.separator == ' ' ||
           (f.separator == ',' && cells[i].cells > f.cells && cells[i].numbers == 0 &&
            named_cells(lines[i].text, f.separator) == f.cells);
  };
  std::size_t best = lines.size(), most_rows = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].comment || cells[i].numbers > 0 || cells[i].texts == 0 || !fits(i)) continue;
    const bool units = !is_row(i + 1) && is_row(i + 2) && cells[i + 1].cells == cells[i].cells &&
                       is_units_row(lines[i + 1].text, f.separator);
    if (!units && !is_row(i + 1)) continue;
    std::size_t rows = 0;
    for (std::size_t k = i + 1;
         k < lines.size() && (k == i + 1 || cells[k].numbers > 0 || !fits(k) || !is_row(k + 1)); ++k)
      rows += is_row(k) && cells[k].cells == f.cells;
    const bool again = best < lines.size() && lines[i].text == lines[best].text;  // the logger was restarted
    if (best < lines.size() && (rows <= most_rows || again)) continue;
    best = i, most_rows = rows, f.has_units = units;
  }
  const auto first = static_cast<std::size_t>(
      std::find_if(lines.begin(), lines.end(), [](const SampleLine& l) { return !l.comment; }) -
      lines.begin());
  if (best == lines.size()) best = first;
  if (best == lines.size()) return;
  const bool like_the_next = is_row(first) && is_row(first + 1) &&
                             cells[first].numbers == cells[first + 1].numbers &&
                             cells[first].texts == cells[first + 1].texts;
  if (best == first && is_row(first) && (cells[first].texts == 0 || like_the_next)) {
    f.has_header = false;
    if (first > 0 && cells_by(lines[first - 1].text.substr(1), f.separator).size() == f.cells)
      --best, f.has_header = f.header_is_comment = true;
  }
  f.header = lines[best].offset;
  f.header_line = lines[best].number;
  for (std::size_t i = 0; i < best; ++i) f.preamble += !lines[i].comment;
  if (f.has_header) find_keyed_header(f, lines, f.has_units ? best + 1 : best);
}

/// Whether a cell of a row shows the decimal mark.
bool shows_decimals(const TableFormat& f, const std::vector<SampleLine>& lines) {
  for (const SampleLine& line : lines)
    if (!line.comment)
      for (const std::string_view cell : cells_by(line.text, f.separator))
        if (is_numeric(cell, f.decimal) && cell.find(f.decimal) != std::string_view::npos) return true;
  return false;
}

/// Whether each decimal comma of the rows stands like one of thousands, with three digits behind it.
bool all_like_thousands(const TableFormat& f, const std::vector<SampleLine>& lines) {
  constexpr std::size_t fewest = 8;
  std::size_t commas = 0;
  for (const SampleLine& line : lines) {
    if (line.comment) continue;
    for (const std::string_view cell : cells_by(line.text, f.separator)) {
      if (!is_numeric(cell, ',') || cell.find(',') == std::string_view::npos) continue;
      std::string pointed(cell);
      std::replace(pointed.begin(), pointed.end(), ',', '.');
      if (!may_be_thousands(pointed) || pointed.size() - pointed.find('.') != 4) return false;
      ++commas;
    }
  }
  return commas >= fewest;
}

/// Whether a cell has points between groups of three digits before its decimal comma: `1.234,5`.
bool has_grouping_points(const TableFormat& f, const std::vector<SampleLine>& lines) {
  for (const SampleLine& line : lines)
    if (!line.comment)
      for (const std::string_view cell : cells_by(line.text, f.separator)) {
        std::string copy(cell);
        if (cell.find('.') != std::string_view::npos && remove_thousands(copy) == ',') return true;
      }
  return false;
}

/// Whether `"1,5"` in a table that commas separate is a number: in several rows, and none has a decimal
/// point.
bool has_quoted_commas(const std::vector<SampleLine>& lines) {
  std::size_t rows = 0;
  for (const SampleLine& line : lines) {
    if (line.comment) continue;
    std::size_t commas = 0;
    for (const std::string_view cell : cells_by(line.text, ',')) {
      if (is_numeric(cell, '.') && cell.find('.') != std::string_view::npos) return false;
      commas += is_numeric(cell, ',') && cell.find(',') != std::string_view::npos;
    }
    rows += commas > 0;
  }
  return rows > 1;
}

constexpr std::string_view hexadecimal_digits = "0123456789abcdefABCDEF";

/// `0x1AF`, of at most 13 digits, which a double holds.
bool is_hexadecimal(std::string_view text) {
  return text.size() > 2 && text.size() <= 15 && text[0] == '0' && (text[1] | 0x20) == 'x' &&
         text.find_first_not_of(hexadecimal_digits, 2) == std::string_view::npos;
}

}  // namespace

RecordEnd find_record_end(std::string_view text, std::string_view separators) {
  constexpr std::size_t none = std::string_view::npos;
  bool quoted = false, starts = true;
  std::size_t opened = none, closed = none;  // behind a closed one another one is doubled
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' && quoted) {
      quoted = false, closed = i;
    } else if (c == '"' && (starts || closed + 1 == i)) {
      if (starts) opened = i;
      quoted = true, starts = false;
    } else if (c == '\n' && !quoted) {
      return {i, none};
    } else if (!quoted) {
      starts = separators.find(c) != none || (starts && is_blank(c));
    }
  }
  return {none, quoted ? opened : none};
}

std::string_view bare_cell(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trimmed(cell.substr(1, cell.size() - 2));
  return cell;
}

std::string_view without_text_mark(std::string_view cell) {
  constexpr std::string_view of_numbers = "0123456789+-.,";
  const bool marked =
      cell.size() > 1 && cell[0] == '\'' && of_numbers.find(cell[1]) != std::string_view::npos;
  return marked && (is_numeric(cell.substr(1), '.') || is_numeric(cell.substr(1), ',')) ? cell.substr(1)
                                                                                        : cell;
}

Commas commas_of(const std::vector<std::string>& cells) {
  bool points = false, commas = false, decimal = false;
  for (const std::string& cell : cells) {
    points = points || cell.find('.') != std::string::npos;
    if (cell.find(',') == std::string::npos || !is_numeric(cell, ',')) continue;
    std::string pointed = cell;
    std::replace(pointed.begin(), pointed.end(), ',', '.');
    commas = true;
    decimal = decimal || !may_be_thousands(pointed);
  }
  return !commas ? Commas::none : decimal && !points ? Commas::decimal : Commas::ambiguous;
}

NumberAndUnit number_and_unit(std::string_view cell, char decimal) {
  const std::size_t end = cell.find_last_of("0123456789") + 1;
  if (end == 0 || is_hexadecimal(cell) || !is_numeric(cell.substr(0, end), decimal)) return {};
  std::string unit = unit_in_words(trimmed(cell.substr(end)));
  return unit.empty() ? NumberAndUnit{} : NumberAndUnit{cell.substr(0, end), std::move(unit)};
}

bool is_unit_behind_comma(std::string_view cell) { return !unit_in_words(cell).empty(); }

bool is_numeric(std::string_view text, char decimal) {
  if (is_hexadecimal(text)) return true;
  std::size_t i = !text.empty() && (text[0] == '-' || text[0] == '+'), digits = 0;
  bool mark = false;
  for (; i < text.size() && (is_decimal_digit(text[i]) || (text[i] == decimal && !mark)); ++i) {
    mark = mark || text[i] == decimal;
    digits += is_decimal_digit(text[i]);
  }
  if (digits == 0) return false;
  if (i < text.size() && std::string_view("eEdD").find(text[i]) != std::string_view::npos) {
    i += 1 + (i + 1 < text.size() && (text[i + 1] == '-' || text[i + 1] == '+'));
    if (i >= text.size()) return false;
    while (i < text.size() && is_decimal_digit(text[i])) ++i;
  }
  return i == text.size();
}

bool may_be_thousands(std::string_view cell) {
  if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
  const std::size_t point = cell.find('.');
  if (point == std::string::npos || point == 0 || point > 3 || cell[0] == '0' || cell.size() < point + 4)
    return false;
  const auto digits_from = [&](std::size_t at) {
    return static_cast<std::size_t>(std::find_if_not(cell.begin() + at, cell.end(), is_decimal_digit) -
                                    cell.begin()) -
           at;
  };
  return digits_from(0) == point && digits_from(point + 1) == 3;
}

Fault ambiguous_point(const Place& place, const std::string& key, const std::string& cell) {
  return {place, key, "a point in a table of decimal commas: of thousands, or of decimals?", quoted(cell),
          "write all digits without it, or a decimal comma"};
}

bool replace_decimal_comma(std::string& cell) {
  const std::size_t comma = cell.find(',');
  if (comma == std::string::npos || comma == 0 || cell.find('.') != std::string::npos) return false;
  if (!is_decimal_digit(cell[comma - 1]) || comma + 1 >= cell.size() || !is_decimal_digit(cell[comma + 1]))
    return false;
  cell[comma] = '.';
  return true;
}

std::optional<char> remove_thousands(std::string& cell) {
  static constexpr std::string_view marks[]{".", ",", "'", "\u2019", "\u00a0", "\u202f", " "};
  const auto digits_at = [&](std::size_t at) {
    return std::min(cell.find_first_not_of("0123456789", at), cell.size()) - at;
  };
  const std::size_t sign = cell.starts_with('-') || cell.starts_with('+'), first = digits_at(sign);
  if (first < 1 || first > 3) return std::nullopt;
  for (const std::string_view mark : marks) {
    std::string plain = cell.substr(0, sign + first);
    std::size_t at = sign + first, groups = 0;
    for (; cell.compare(at, mark.size(), mark) == 0 && digits_at(at + mark.size()) == 3; ++groups) {
      plain += cell.substr(at + mark.size(), 3);
      at += mark.size() + 3;
    }
    const char decimal = at < cell.size() ? cell[at] : '\0';
    const bool marks_decimals = (decimal == '.' || decimal == ',') && mark[0] != decimal;
    if (groups == 0 || (decimal != '\0' && !marks_decimals)) continue;
    const bool ambiguous = (mark == "." || mark == ",") && groups == 1 && !marks_decimals;
    if (ambiguous || (marks_decimals && at + 1 + digits_at(at + 1) != cell.size())) continue;
    cell = marks_decimals ? plain + '.' + cell.substr(at + 1) : plain;
    return decimal;
  }
  return std::nullopt;
}

bool make_decimal_notation(std::string& cell) {
  if (is_hexadecimal(cell)) {
    cell = std::to_string(std::stoull(cell, nullptr, 16));
    return true;
  }
  const std::size_t exponent = cell.find_first_of("dD");
  if (exponent == std::string::npos || !is_numeric(cell, '.')) return false;
  cell[exponent] = 'E';
  return true;
}

void make_plain_number(std::string& cell) {
  if (!remove_thousands(cell)) replace_decimal_comma(cell);
}

TableFormat recognize_table(std::string_view head) {
  TableFormat f;
  const std::vector<SampleLine> lines = lines_of(head);
  std::array<Separation, 10> candidates{Separation{',', '.'}, {';', '.'},  {';', ','},  {'|', '.'},
                                        {'|', ','},           {'\t', '.'}, {'\t', ','}, {' ', '.'},
                                        {' ', ','},           {',', ','}};
  const auto best_with = [&](bool units) {
    for (Separation& c : candidates) rate(c, lines, units);
    if (!has_quoted_commas(lines)) candidates.back().score = 0;
    const Separation* best = candidates.data();
    for (const Separation& c : candidates)
      if (c.score > std::max<std::int64_t>(best->score, 0)) best = &c;
    return best;
  };
  const Separation* best = best_with(false);
  bool with_units = false;  // where nothing else is a table: cells of a preamble have units, too
  if (best->score <= 0) {
    with_units = best_with(true)->score > 0;
    best = best_with(with_units);
  }
  f.separator = best->separator;
  f.decimal = best->decimal;
  f.cells = best->cells;
  if (best->cells == 0) {
    // No row at all: the first line decides.
    const auto first =
        std::find_if(lines.begin(), lines.end(), [](const SampleLine& l) { return !l.comment; });
    if (first == lines.end()) return f;
    const auto marks = [&](char c) { return std::count(first->text.begin(), first->text.end(), c); };
    for (const char c : {';', '\t'})
      if (marks(c) > marks(f.separator)) f.separator = c;
  }
  f.decimal_unknown = f.separator != ',' && !shows_decimals(f, lines);
  f.maybe_thousands = f.decimal == ',' && all_like_thousands(f, lines);
  f.points_group = f.decimal == ',' && has_grouping_points(f, lines);
  find_header(f, lines, with_units);
  return f;
}

}  // namespace qerr
