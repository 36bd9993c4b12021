#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/text.hpp"
#include "input/csv.hpp"

/// The rows of a table. The fast path reads rows of unquoted numbers in one pass without a copy; a row with
/// quotation marks or faults, or one that crosses the end of the buffer, is read again by the general path.
namespace qerr {

namespace {

constexpr std::array<double, 20> powers{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,
                                        1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19};
constexpr std::uint64_t most_exact = std::uint64_t{1} << 53;

unsigned digit(char c) { return static_cast<unsigned>(static_cast<unsigned char>(c)) - '0'; }

/// The end of a cell that is not chosen: its comma or line end. Null, or another byte, if the general path
/// must read the row: the cell crosses the end of the buffer, contains a line end, or has text after its
/// quotation mark.
const char* skip_cell(const char* p) {
  if (*p == '"') {
    for (++p; *p != '"' || *++p == '"'; ++p)
      if (*p == '\n' || *p == '\0') return nullptr;
    return p;
  }
  while (*p != ',' && *p != '\n' && *p != '\r' && *p != '\0') ++p;
  return p;
}

/// The end of the digits of an exponent whose `e` is at `p`; null if it has no digits.
const char* skip_exponent(const char* p) {
  p += 1 + (p[1] == '-' || p[1] == '+');
  if (digit(*p) > 9) return nullptr;
  while (digit(*p) <= 9) ++p;
  return p;
}

}  // namespace

/// Reads the number at `p`, correctly rounded: an integer below 2^53 divided by a power of ten up to 10^19 is
/// one rounding of exact operands (Clinger 1990); std::from_chars reads any other number.
/// @returns its end, or null if there is no number, it is out of the range of double, or the buffer ends in
/// it
const char* CsvReader::fast_number(const char* p, double& value, Written& written) {
  const char* const begin = p;
  const bool negative = *p == '-';
  p += negative;
  const char* const first = p;
  std::uint64_t whole = 0;
  for (unsigned d; (d = digit(*p)) <= 9; ++p) whole = 10 * whole + d;
  auto digits = p - first;
  std::ptrdiff_t decimals = 0;
  if (*p == '.') {
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
    const auto [end, failure] = std::from_chars(begin, p, value);
    if (failure != std::errc{} || end != p) return nullptr;
    if (p != power && std::from_chars(power + 1 + (power[1] == '+'), p, exponent).ec != std::errc{})
      return nullptr;
    int zeros = 0;  // leading zeros are not significant
    for (const char* c = first; *c == '0' || *c == '.'; ++c) zeros += *c == '0';
    written.most_digits = std::max(written.most_digits, static_cast<int>(digits) - zeros);
  }
  const int places = static_cast<int>(decimals) - exponent;
  written.most_decimals = std::max(written.most_decimals, places);
  written.least_decimals = std::min(written.least_decimals, places);
  return p;
}

/// Reads a row of unquoted numbers. @returns its end, or null if the general path must read the row
const char* CsvReader::fast_row(double* values, std::ptrdiff_t stride) {
  const char* p = buffer_.data() + row_;
  const std::ptrdiff_t* const plan = plan_.data();
  const std::size_t last = plan_.size() - 1;
  for (std::size_t i = 0;; ++i) {
    const std::ptrdiff_t chosen = plan[i];
    while (*p == ' ' || *p == '\t') ++p;
    p = chosen < 0 ? skip_cell(p)
                   : fast_number(p, values[chosen * stride], written_[static_cast<std::size_t>(chosen)]);
    if (!p) return nullptr;
    if (i == last) break;
    if (*p++ != ',') return nullptr;
  }
  p += *p == '\r';
  return *p == '\n' ? p + 1 : nullptr;
}

bool CsvReader::next(double* values, std::ptrdiff_t stride) {
  row_ = next_;
  line_ = next_line_;
  if (const char* const end = fast_row(values, stride)) {
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
    const char* const end = record_end(buffer_.data() + row_);
    const char* const begin = buffer_.data() + row_;
    next_ = static_cast<std::size_t>(end - buffer_.data()) + 1;
    next_line_ += 1 + std::count(begin, end, '\n');
    if (!std::all_of(begin, end, is_blank)) return true;
  }
}

/// The line end of the record at `row_`, outside quotation marks; fills the buffer until it is found.
/// @param begin  of the record, in the buffer
const char* CsvReader::record_end(const char* begin) {
  while (true) {
    const char* const end = buffer_.data() + end_;
    const char *opened = nullptr, *closed = nullptr;
    bool starts = true, quoted = false;
    for (const char* p = begin; p != end; ++p) {
      if (quoted) {
        if (*p == '"') quoted = false, closed = p;
      } else if (*p == '"' && (starts || p - 1 == closed)) {
        if (starts) opened = p;
        quoted = true;  // again after a doubled quotation mark
        starts = false;
      } else if (*p == '\n') {
        return p;
      } else {
        starts = *p == ',' || (starts && is_blank(*p));
      }
    }
    const bool too_long = end_ - row_ > limits_.longest_row;
    const auto offset = static_cast<std::size_t>(quoted ? opened - (buffer_.data() + row_) : 0);
    if (too_long || !fill()) {
      if (quoted)
        throw Error({place_at(buffer_.data() + row_ + offset), "", "a quotation mark is not closed", "",
                     "end the cell with \"; inside a cell it is doubled"});
      throw Error({{file(), line(), 1},
                   "",
                   "a line is too long",
                   "",
                   "at most " + std::to_string(limits_.longest_row) + " bytes"});
    }
    begin = buffer_.data() + row_;
  }
}

/// Splits a record into its cells (RFC 4180): a quoted cell may contain commas and line ends, and a doubled
/// quotation mark is one.
std::vector<CsvReader::Cell> CsvReader::cells_of(const char* begin, const char* end) const {
  std::vector<Cell> cells;
  const char* p = begin;
  while (true) {
    while (p != end && is_blank(*p)) ++p;
    Cell cell{{}, p, p != end && *p == '"'};
    if (cell.quoted) {
      for (++p; p != end && (*p != '"' || (p + 1 != end && *++p == '"')); ++p) cell.text += *p;
      // p is after the closing quotation mark, or on it at the end of the record
      p += p != end && *p == '"';
      while (p != end && is_blank(*p)) ++p;
      if (p != end && *p != ',')
        throw Error(
            {place_at(p), "", "text follows the closing quote", "", "a quote within a cell is doubled"});
    } else {
      while (p != end && *p != ',') ++p;
      cell.text.assign(cell.begin, p);
      while (!cell.text.empty() && is_blank(cell.text.back())) cell.text.pop_back();
      if (const auto at = cell.text.find('\r'); at != std::string::npos)
        throw Error({place_at(cell.begin + at), "", "a carriage return without a line feed", "",
                     "end lines with LF or CR LF"});
    }
    cells.push_back(std::move(cell));
    if (p == end) return cells;
    ++p;
  }
}

void CsvReader::ragged(std::size_t cells) const {
  const char* const row = buffer_.data() + row_;
  std::string remedy = counted(header_.size(), "cell");
  if (*row == '#')
    remedy = "comments are allowed only before the header";
  else if (unterminated_ && next_ == end_)
    remedy += "; the file ends within this row: was the recording cut off?";
  throw Error({{file(), line(), 1},
               "",
               "the row must have as many cells as the header",
               counted(cells, "cell"),
               remedy});
}

void CsvReader::general_cell(const Cell& cell, std::size_t chosen, double& value) {
  const std::string ended = cell.text + ',';
  const char* begin = ended.c_str();
  begin += *begin == '+' && begin[1] != '-';
  const char* const end = fast_number(begin, value, written_[chosen]);
  if (end && end == ended.c_str() + cell.text.size()) return;
  throw Error({place_at(cell.begin), header_[chosen_[chosen]],
               cell.text.empty() ? "the cell is empty" : "not a finite decimal number",
               cell.text.empty() ? "" : "'" + cell.text + "'", "write a plain number, or leave the row out"});
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
  return true;
}

}  // namespace qerr
