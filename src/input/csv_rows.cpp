#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/core/quantity.hpp"

/// The rows of a table. The fast path reads rows of unquoted numbers in one pass without a copy; a row with
/// quotation marks or faults, or one that crosses the end of the buffer, is read again by the general path.
namespace qerr {

namespace {

constexpr std::array<double, 20> powers{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,
                                        1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19};
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t most_exact = std::uint64_t{1} << 53;

unsigned digit(char c) { return static_cast<unsigned>(static_cast<unsigned char>(c)) - '0'; }

/// The end of a cell that is not chosen: its separator or line end. Null, or another byte, if the general
/// path must read the row: the cell crosses the end of the buffer, contains a line end, or has text after its
/// quotation mark.
const char* skip_cell(const char* p, char separator) {
  if (*p == '"') {
    for (++p; *p != '"' || *++p == '"'; ++p)
      if (*p == '\n' || *p == '\0') return nullptr;
    return p;
  }
  while (*p != separator && (separator != ' ' || *p != '\t') && *p != '\n' && *p != '\r' && *p != '\0') ++p;
  return p;
}

/// std::from_chars for a number that ends at `end`, whose decimal mark is perhaps a comma.
bool converts(const char* begin, const char* end, char decimal, double& value) {
  std::string text;
  if (decimal != '.') {
    text.assign(begin, end);
    std::replace(text.begin(), text.end(), decimal, '.');
    begin = text.data(), end = text.data() + text.size();
  }
  const auto [last, failure] = std::from_chars(begin, end, value);
  return failure == std::errc{} && last == end;
}

/// The end of the digits of an exponent whose `e` is at `p`; null if it has no digits.
const char* skip_exponent(const char* p) {
  p += 1 + (p[1] == '-' || p[1] == '+');
  if (digit(*p) > 9) return nullptr;
  while (digit(*p) <= 9) ++p;
  return p;
}

/// Reads the number at `p`, correctly rounded: an integer below 2^53 divided by a power of ten up to 10^19 is
/// one rounding of exact operands (Clinger 1990); std::from_chars reads any other number.
const char* read_number_with(char decimal, const char* p, double& value, WrittenNumbers& written) {
  const char* const begin = p;
  const bool negative = *p == '-';
  p += negative;
  const char* const first = p;
  std::uint64_t whole = 0;
  for (unsigned d; (d = digit(*p)) <= 9; ++p) whole = 10 * whole + d;
  auto digits = p - first;
  std::ptrdiff_t decimals = 0;
  if (*p == decimal) {
    const char* const point = ++p;
    for (unsigned d; (d = digit(*p)) <= 9; ++p) whole = 10 * whole + d;
    decimals = p - point;
    digits += decimals;
  }
  if (digits == 0 || *p == '\0') return nullptr;
  int exponent = 0;
  if (digits <= 19 && whole <= most_exact && *p != 'e' && *p != 'E') {
    const double size = static_cast<double>(static_cast<std::int64_t>(whole)) / powers[decimals];
    value = negative ? -size : size;
    written.largest = std::max(written.largest, whole);
  } else {
    const char* const power = p;
    if ((*p == 'e' || *p == 'E') && !(p = skip_exponent(p))) return nullptr;
    if (*p == '\0') return nullptr;
    if (!converts(begin, p, decimal, value)) return nullptr;
    if (p != power && std::from_chars(power + 1 + (power[1] == '+'), p, exponent).ec != std::errc{})
      return nullptr;
    int zeros = 0;  // leading zeros are not significant
    for (const char* c = first; *c == '0' || *c == decimal; ++c) zeros += *c == '0';
    written.most_digits = std::max(written.most_digits, static_cast<int>(digits) - zeros);
  }
  const int places = static_cast<int>(decimals) - exponent;
  written.most_decimals = std::max(written.most_decimals, places);
  written.least_decimals = std::min(written.least_decimals, places);
  return p;
}

/// Makes the decimal comma of a number a point; other texts are left alone.
void make_decimal_point(char* begin, const char* end) {
  if (!is_numeric({begin, static_cast<std::size_t>(end - begin)}, ',')) return;
  std::replace(begin, begin + (end - begin), ',', '.');
}

}  // namespace

bool is_missing(std::string_view text) {
  static constexpr std::string_view words[]{"",     "nan",  "na",  "n/a", "#n/a", "#nv",
                                            "null", "none", "nil", "-",   "--"};
  // What Excel writes in place of a number: #DIV/0!, #WERT!, #REF!, #NAME?, #####.
  if (text.starts_with('#') && (text.ends_with('!') || text.ends_with('?') || text.ends_with('#')))
    return true;
  return contains(words, lower_case(text.substr(0, 5)));
}

const char* read_number(const char* p, double& value, WrittenNumbers& written) {
  return read_number_with('.', p, value, written);
}

/// Reads a row of unquoted numbers. @returns its end, or null if the general path must read the row
const char* CsvReader::fast_row(double* values, std::ptrdiff_t stride) {
  const char separator = format_.separator, decimal = format_.decimal;
  if (separator == decimal || !cell_units_.empty() || !comma_columns_.empty()) return nullptr;
  const char* p = buffer_.data() + row_;
  const std::ptrdiff_t* const plan = plan_.data();
  const std::size_t last = plan_.size() - 1;
  for (std::size_t i = 0;; ++i) {
    const std::ptrdiff_t chosen = plan[i];
    while (*p == ' ' || (separator != '\t' && *p == '\t')) ++p;
    const char* const cell = p;
    if (chosen >= 0) {
      p = read_number_with(decimal, cell, values[chosen * stride],
                           written_[static_cast<std::size_t>(chosen)]);
      if (!p && limits_.empty_cells && (*cell == separator || *cell == '\n' || *cell == '\r')) {
        values[chosen * stride] = no_number;
        p = cell;
      }
    } else {
      p = skip_cell(cell, separator);
      if (chosen < -1) {
        if (!p || *cell == '"' || (p != cell && is_blank(p[-1]))) return nullptr;
        if (decimal != '.') make_decimal_point(buffer_.data() + (cell - buffer_.data()), p);
        texts_[static_cast<std::size_t>(-2 - chosen)] = {cell, p};
      }
    }
    if (!p) return nullptr;
    if (i == last) break;
    if (*p != separator && (separator != ' ' || *p != '\t')) return nullptr;
    ++p;
  }
  if (separator == ' ')
    while (*p == ' ' || *p == '\t') ++p;
  p += *p == '\r';
  return *p == '\n' ? p + 1 : nullptr;
}

bool CsvReader::next(double* values, std::ptrdiff_t stride) {
  row_ = next_;
  line_ = next_line_;
  if (buffer_[row_] == format_.separator && only_empty_rows_follow()) return false;
  if (const char* const end = remarks_ ? nullptr : fast_row(values, stride)) {
    next_ = static_cast<std::size_t>(end - buffer_.data());
    ++next_line_;
    return true;
  }
  return next_record() && general_row(values, stride);
}

bool CsvReader::next_texts(std::vector<std::string>& cells, std::vector<Place>& places) {
  if (!next_record()) return false;
  cells.clear();
  places.clear();
  for (Cell& cell : cells_of_row()) {
    places.push_back(place_at(cell.begin));
    cells.push_back(std::move(cell.text));
  }
  return true;
}

/// Advances to the next record that is not blank. @returns false at the end
bool CsvReader::next_record() {
  while (true) {
    row_ = next_;
    line_ = next_line_;
    if (next_ == end_ && !fill()) return false;
    if (only_empty_rows_follow()) return false;
    const char* const end = record_end();
    const char* const begin = buffer_.data() + row_;
    next_ = static_cast<std::size_t>(end - buffer_.data()) + 1;
    next_line_ += 1 + std::count(begin, end, '\n');
    const bool blank = std::all_of(begin, end, is_blank);
    const bool behind = behind_blank_ || remarks_;
    behind_blank_ = blank;
    if (blank) continue;
    // Summaries stand behind a blank line: `Mean,12.3`. In a column that is not read words may stand in any
    // row.
    const bool word = is_letter(*std::find_if_not(begin, end, is_blank));
    remarks_ = limits_.recognize && word && behind && !plan_.empty() && plan_[0] != -1;
    if (remarks_) {
      ++left_out_;
      continue;
    }
    // Loggers write remarks between the rows, and their header once more where they start again.
    if (limits_.recognize && (*begin == '#' || std::string_view(begin, end - begin) == header_line_))
      continue;
    return true;
  }
}

/// Whether the rest of the table are rows without a filled cell, as spreadsheets write below one: `;;;;`.
bool CsvReader::only_empty_rows_follow() {
  if (line_ < filled_ || format_.separator == ' ') return false;
  std::size_t rows = 0, empty = 0, length = 0;
  bool cells = false;
  for (bool more = true; more; more = fill()) {
    for (; row_ + length < end_; ++length) {
      const char c = buffer_[row_ + length];
      cells = cells || separates(c);
      if (c == '\n') ++rows, empty += std::exchange(cells, false);
      if (c == '\n' || c == '"' || is_blank(c) || separates(c)) continue;
      filled_ = line_ + static_cast<std::int64_t>(rows);
      return false;
    }
  }
  empty_rows_ += empty;
  next_ = row_ = end_;
  return true;
}

/// The line end of the record at `row_`, outside quotation marks; fills the buffer until it is found.
const char* CsvReader::record_end() {
  while (true) {
    const std::string_view data(buffer_.data() + row_, end_ - row_);
    const RecordEnd found =
        find_record_end(data, format_.separator == ' ' ? " \t" : std::string_view(&format_.separator, 1));
    if (found.at != std::string_view::npos) return data.data() + found.at;
    if (data.size() <= limits_.longest_row && fill()) continue;
    if (found.open != std::string_view::npos)
      throw Error(place_at(buffer_.data() + row_ + found.open), "", "a quotation mark is not closed", "",
                  "end the cell with \"; inside a cell it is doubled");
    throw Error({file(), line(), 1}, "", "a line is too long", "",
                "at most " + std::to_string(limits_.longest_row) + " bytes");
  }
}

void CsvReader::ragged(std::size_t cells) const {
  const char* const row = buffer_.data() + row_;
  std::string remedy = counted(header_.size(), "cell");
  if (*row == '#')  // of another table than a log
    remedy = "comments are allowed only before the header";
  else if (unterminated_ && next_ == end_)
    remedy += "; the file ends within this row: was the recording cut off?";
  throw Error({file(), line(), 1}, "", "the row must have as many cells as the header",
              counted(cells, "cell"), remedy);
}

/// The number of a cell with a decimal point in place of a comma.
/// @throws Error (input) for a point that may be one of thousands
std::string CsvReader::with_decimal_point(const Cell& cell, std::size_t chosen) {
  std::string text = cell.text;
  if (constexpr std::string_view minus = "\u2212"; text.starts_with(minus))
    text.replace(0, minus.size(), "-");
  if (!limits_.recognize || is_numeric(text, '.')) {
    const bool either = format_.decimal == ',' && may_be_thousands(text);
    if (either && format_.points_group)
      std::erase(text, '.');
    else if (either)
      throw Error(ambiguous_point(place_at(cell.begin), header_[chosen_[chosen]], text));
    if (limits_.recognize) make_decimal_notation(text);
    return text;
  }
  const bool commas = format_.decimal == ',' || format_.decimal_unknown;
  // Beside decimal points a comma is none: `1,002`.
  if (!commas && (format_.separator != ',' || cell.quoted) && is_numeric(text, ',')) {
    std::string pointed = text;
    std::replace(pointed.begin(), pointed.end(), ',', '.');
    if (may_be_thousands(pointed)) std::erase(text, ',');
    return text;
  }
  const auto mark = remove_thousands(text);
  if (mark == ',' || (!mark && commas && replace_decimal_comma(text))) format_.decimal = ',';
  return text;
}

/// The text of a cell without the unit that all numbers of its column have, and with a decimal point where
/// the column has commas of its own.
/// @throws Error (input) for other numbers in such a column, whose marks may be of thousands
std::string CsvReader::plain_text(const Cell& cell, std::size_t column) const {
  std::string text = cell.text;
  if (!cell_units_.empty() && !cell_units_[column].empty())
    if (const NumberAndUnit parts = number_and_unit(text, format_.decimal); parts.unit == cell_units_[column])
      text = std::string(parts.number);
  if (!has_commas(column) || is_missing(text)) return text;
  if (text.find('.') != std::string::npos || !is_numeric(text, ','))
    throw Error(place_at(cell.begin), header_[column],
                "no plain number with a decimal comma, which the column's others have", "'" + cell.text + "'",
                "write all numbers with one decimal mark, and without marks of thousands");
  std::replace(text.begin(), text.end(), ',', '.');
  return text;
}

void CsvReader::general_cell(const Cell& cell, std::size_t chosen, double& value) {
  if (limits_.empty_cells && is_missing(cell.text)) {
    value = no_number;
    return;
  }
  Cell plain = cell;
  plain.text = plain_text(cell, chosen_[chosen]);
  const std::string ended = with_decimal_point(plain, chosen) + '\n';
  const char* begin = ended.c_str();
  begin += *begin == '+' && begin[1] != '-';
  const char* const end = read_number(begin, value, written_[chosen]);
  if (end && end == ended.c_str() + ended.size() - 1) return;
  const std::string unit = number_and_unit(cell.text, format_.decimal).unit;
  const bool comma = format_.separator != ',' && is_numeric(cell.text, ',');
  throw Error(
      place_at(cell.begin), header_[chosen_[chosen]],
      cell.text.empty() ? "the cell is empty"
      : comma           ? "a decimal comma, beside decimal points in other rows or columns"
                        : "not a finite decimal number",
      cell.text.empty() ? "" : "'" + cell.text + "'",
      cell.text.find("\u00b0") != std::string::npos && cell.text.find('\'') != std::string::npos
          ? "write degrees, minutes and seconds as decimal degrees, 12.582417 in a column '" +
                column_name(header_[chosen_[chosen]]).name + " [deg]'"
      : comma ? "write all numbers with one decimal mark"
      : unit.empty()
          ? "write a plain number, or leave the row out" + (is_missing(cell.text) ? limits_.empty_remedy : "")
          : "write the unit in the header, such as '" + column_name(header_[chosen_[chosen]]).name + " [" +
                unit + "]', and plain numbers");
}

std::vector<CsvReader::Cell> CsvReader::cells_of_row() const {
  std::vector<Cell> cells = cells_of(buffer_.data() + row_, buffer_.data() + next_ - 1);
  if (cells.size() != header_.size()) ragged(cells.size());
  return cells;
}

bool CsvReader::general_row(double* values, std::ptrdiff_t stride) {
  const std::vector<Cell> cells = cells_of_row();
  for (std::size_t i = 0; i < chosen_.size(); ++i)
    general_cell(cells[chosen_[i]], i, values[static_cast<std::ptrdiff_t>(i) * stride]);
  for (std::size_t i = 0; i < text_columns_.size(); ++i) {
    std::string text = plain_text(cells[text_columns_[i]], text_columns_[i]);
    if (format_.decimal == ',' || format_.decimal_unknown)
      make_decimal_point(text.data(), text.data() + text.size());
    text_cells_[i] = text + '\n';
    texts_[i] = std::string_view(text_cells_[i]).substr(0, text.size());
  }
  return true;
}

}  // namespace qerr
