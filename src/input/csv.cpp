#include "input/csv.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/log_table.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Zeros after the last byte: no number or text contains one, so that scanning stops there.
constexpr std::size_t padding = 16;

/// Moves a place over a text; its column counts code points.
void advance(Place& place, const char* begin, const char* end) {
  const char* start = begin;
  for (const char* p = begin; p != end; ++p)
    if (*p == '\n') {
      ++place.line;
      place.column = 1;
      start = p + 1;
    }
  place.column += static_cast<int>(display_width({start, static_cast<std::size_t>(end - start)}));
}

/// What stands in place of a unit: `-`, `(None)`.
bool is_no_unit(const std::string& unit) {
  return unit.empty() || unit == "-" || unit == "None" || unit == "(None)";
}

}  // namespace

ColumnName column_name(const std::string& cell) {
  // Blanks before a name belong to it: an unquoted cell has none. An apostrophe says that it is no formula.
  const bool marked =
      cell.size() > 1 && cell[0] == '\'' && std::string_view("=+-@'").find(cell[1]) != std::string_view::npos;
  const std::string text = cell.substr(marked ? 1 : 0);
  const std::size_t open = text.rfind('[');
  if (open == std::string::npos || !text.ends_with(']')) return {text, {}};
  const std::size_t last = text.find_last_not_of(" \t\r", open - 1);
  return {open == 0 || last == std::string::npos ? std::string() : text.substr(0, last + 1),
          std::string(trimmed(text.substr(open + 1, text.size() - open - 2)))};
}

CsvReader::CsvReader(const std::string& path, const CsvLimits& limits)
    : source_(path, limits.recognize), limits_(limits), buffer_(limits.block + padding) {
  // Bytes by which the format is recognized.
  const std::size_t sample = limits_.recognize ? std::min<std::size_t>(1 << 16, limits_.longest_row) : 8;
  while (end_ < sample && fill()) {
  }
  if (end_ == 0) throw Error({file(), 1, 1}, "", "the file is empty", "", "a header and rows of numbers");
  if (std::string_view(buffer_.data(), end_).starts_with("\xEF\xBB\xBF")) row_ = next_ = 3;
  if (limits_.recognize) recognize();
  read_header();
}

void CsvReader::recognize() {
  format_ = recognize_table({buffer_.data() + next_, end_ - next_});
  if (format_.maybe_thousands)
    throw Error({file(), format_.header_line + 1, 1}, "",
                "commas with three digits behind each: of thousands, or of decimals?", "",
                "write numbers without marks of thousands, or with decimal points");
  next_line_ += format_.header_line - 1;
  row_ = next_ += format_.header;
}

/// Moves the current row to the front of the buffer and reads more. @returns false at the end of the source
bool CsvReader::fill() {
  if (ended_) return false;
  std::memmove(buffer_.data(), buffer_.data() + row_, end_ - row_);
  next_ -= row_;
  end_ -= row_;
  row_ = 0;
  if (end_ + limits_.block / 2 + 1 + padding > buffer_.size())
    buffer_.resize(2 * buffer_.size());  // the row is about as long as a block, or longer
  const std::size_t space = buffer_.size() - padding - end_;
  const std::size_t count =
      source_.read(buffer_.data() + end_, std::max(std::min(space, limits_.block), std::size_t{4}));
  end_ += count;
  ended_ = count == 0;
  if (ended_ && end_ > 0 && buffer_[end_ - 1] != '\n') {
    buffer_[end_++] = '\n';  // every row ends with a line end
    unterminated_ = true;
  }
  std::memset(buffer_.data() + end_, 0, padding - 1);
  return !ended_ || unterminated_;
}

void CsvReader::read_header() {
  while (true) {
    row_ = next_;
    line_ = next_line_;
    if (next_ == end_ && !fill())
      throw Error({file(), line(), 1}, "", "the file has no header", "", "a header and rows of numbers");
    if (!format_.has_header) return number_columns();
    const bool comment = buffer_[next_] == '#';
    const char* end = comment ? nullptr : record_end();
    if (comment) {
      const void* found = std::memchr(buffer_.data() + next_, '\n', end_ - next_);
      if (!found && end_ - next_ <= limits_.longest_row && fill()) continue;
      end = static_cast<const char*>(found);
    }
    if (!end)
      throw Error({file(), line(), 1}, "", "a line is too long", "",
                  "at most " + std::to_string(limits_.longest_row) + " bytes");
    const char* begin = buffer_.data() + row_;
    next_line_ += 1 + std::count(begin, end, '\n');
    next_ = static_cast<std::size_t>(end - buffer_.data()) + 1;
    if ((comment && !format_.header_is_comment) || std::all_of(begin, end, is_blank)) continue;
    if (limits_.semicolons && std::count(begin, end, ';') > std::count(begin, end, ','))
      format_.separator = ';';
    header_line_.assign(begin, end);
    take_header(begin, end);
    break;
  }
  for (std::size_t i = 0; i < header_.size(); ++i)
    for (std::size_t k = 0; k < header_[i].size();) {
      const std::size_t length = header_[i][k] == '\0' ? 0 : utf8_length(header_[i], k);
      if (length == 0)
        throw Error(header_places_[i], "", "the header must be UTF-8 text", "'" + header_[i] + "'",
                    header_[i][k] == '\0' ? "is this a text file?" : "save the file as UTF-8");
      k += length;
    }
  if (std::all_of(header_.begin(), header_.end(), [](const auto& h) { return parse_number(h).has_value(); }))
    throw Error(header_places_[0], "", "the first row must name the columns", "numbers",
                "a header such as time [s],shoulder.counts");
  if (format_.has_units) add_units();
  if (format_.keyed_until > 0) take_keyed_rows();
  if (limits_.recognize) fit_header();
  if (limits_.recognize) look_at_cells();
}

/// Units behind the numbers of a column become that of its header; and columns have decimal commas of their
/// own.
void CsvReader::look_at_cells() {
  constexpr std::size_t sampled = 200;
  const std::vector<std::vector<std::string>> rows = first_rows(sampled);
  std::optional<std::size_t> either;  // a column of commas that may be of thousands
  for (std::size_t i = 0; i < header_.size(); ++i) {
    std::vector<std::string> cells;
    std::string unit;
    bool of_all = true;
    for (const auto& row : rows) {
      if (i >= row.size() || is_missing(row[i])) continue;
      cells.push_back(row[i]);
      const std::string own = number_and_unit(row[i], format_.decimal).unit;
      of_all = of_all && !own.empty() && (unit.empty() || own == unit);
      unit = own;
    }
    if (cells.empty()) continue;
    if (const std::string of_header = measured_name(header_[i]).unit;
        of_all && (of_header.empty() || of_header == unit)) {
      cell_units_.resize(header_.size());
      cell_units_[i] = unit;
      if (of_header.empty()) header_[i] += " [" + unit + ']';
    }
    if (format_.decimal != '.' || format_.separator == ',') continue;
    const Commas commas = commas_of(cells);
    if (commas == Commas::ambiguous) either = i;
    if (commas != Commas::decimal) continue;
    comma_columns_.resize(header_.size());
    comma_columns_[i] = true;
  }
  if (either && !comma_columns_.empty())
    throw Error(header_places_[*either], header_[*either],
                "commas with three digits behind each: of thousands, or of decimals as in other columns?", "",
                "write numbers without marks of thousands, or with decimal points");
}

/// Takes the cells of the header, one after the other, as there may be very many.
void CsvReader::take_header(const char* begin, const char* end) {
  Place place{file(), line(), 1};
  const char* text = begin;
  while (format_.header_is_comment && text != end && (*text == '#' || is_blank(*text))) ++text;
  for (const Cell& cell : cells_of(text, end)) {
    advance(place, begin, cell.begin);
    begin = cell.begin;
    header_.push_back(cell.text);
    header_places_.push_back(place);
  }
}

void CsvReader::number_columns() {
  const char* const end = record_end();
  const std::vector<std::string>& labels = source_.layout().labels();
  for (std::size_t i = cells_of(buffer_.data() + row_, end).size(); i > 0; --i) {
    header_.insert(header_.begin(), i <= labels.size() ? labels[i - 1] : "column " + std::to_string(i));
    header_places_.push_back({file(), line(), 1});
  }
}

/// Adds the units of the row behind the header: `Winkel` and `[deg]` or `deg` are `Winkel [deg]`.
void CsvReader::add_units() {
  if (!next_record()) return;
  const std::vector<Cell> cells = cells_of(buffer_.data() + row_, buffer_.data() + next_ - 1);
  for (std::size_t i = 0; i < std::min(cells.size(), header_.size()); ++i) {
    std::string unit = cells[i].text;
    if (unit.size() > 1 && (unit.front() == '[' || unit.front() == '('))
      unit = trimmed(unit.substr(1, unit.size() - 2));
    if (!is_no_unit(unit)) header_[i] += " [" + unit + ']';
  }
}

/// Names of pairs of a time and a value: `time [ms]`, `Axis1.Counts`, `time of Axis1.Position [ms]`,
/// `Axis1.Position [deg]`.
void CsvReader::take_keyed_rows() {
  std::vector<std::string> units(header_.size());
  std::string of_time;
  while (next_line_ <= format_.keyed_until && next_record()) {
    const std::vector<Cell> cells = cells_of(buffer_.data() + row_, buffer_.data() + next_ - 1);
    const ColumnName key = column_name(cells[0].text);
    if (key.name == "SampleTime") of_time = key.unit;
    for (std::size_t i = 1; key.name == "Unit" && i < std::min(cells.size(), units.size()); i += 2)
      units[i] = cells[i].text;
  }
  const auto with_unit = [](const std::string& name, const std::string& unit) {
    return is_no_unit(unit) ? name : name + " [" + unit + ']';
  };
  for (std::size_t i = 1; i < header_.size(); i += 2) {
    header_[i - 1] = with_unit(i == 1 ? "time" : "time of " + header_[i], of_time);
    header_[i] = with_unit(header_[i], units[i]);
  }
}

/// Makes the header as wide as the rows: they may end with a separator where it does not, or the other way
/// round; between blanks `angle (deg)` is one name, between commas `Angle, deg`.
void CsvReader::fit_header() {
  const bool blanks = format_.separator == ' ';
  if (blanks && header_.size() == format_.cells + 1 && header_[0] == "%") {  // as MATLAB writes a comment
    header_.erase(header_.begin());
    header_places_.erase(header_places_.begin());
  }
  for (std::string& cell : header_)  // `time, angle` above rows that blanks separate
    if (blanks && cell.size() > 1 && cell.ends_with(',')) cell.pop_back();
  const auto is_unit = [&](const std::string& cell) {
    return blanks ? cell.starts_with('(') || cell.starts_with('[') : is_unit_behind_comma(cell);
  };
  const auto units = static_cast<std::size_t>(std::count_if(header_.begin() + 1, header_.end(), is_unit));
  const bool joins = blanks || (format_.separator == ',' && header_.size() == format_.cells + units);
  for (std::size_t i = header_.size(); joins && header_.size() > format_.cells && i-- > 1;) {
    if (!is_unit(header_[i])) continue;
    header_[i - 1] += blanks ? ' ' + header_[i] : " [" + header_[i] + ']';
    header_.erase(header_.begin() + static_cast<std::ptrdiff_t>(i));
    header_places_.erase(header_places_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (format_.cells < 2) return;
  if (header_.size() == format_.cells + 1) {
    // libfranka writes a title before the columns of commands, LabVIEW a column that few rows have.
    auto extra = std::find(header_.begin(), header_.end(), "sent commands");
    if (extra == header_.end() && header_.back() == "Comment") extra = header_.end() - 1;
    if (extra == header_.end() && header_.back().empty()) extra = header_.end() - 1;
    if (extra == header_.end()) return;
    header_places_.erase(header_places_.begin() + (extra - header_.begin()));
    header_.erase(extra);
  } else if (header_.size() + 1 == format_.cells) {
    const auto rows = first_rows(1);
    if (rows.empty() || rows[0].size() != format_.cells || !rows[0].back().empty()) return;
    header_.emplace_back();
    header_places_.push_back(header_places_.back());
  }
}

std::string CsvReader::recognized() const {
  std::vector<std::string> all;
  if (!source_.encoding().empty()) all.emplace_back(source_.encoding());
  if (const std::string layout = source_.layout().description(); !layout.empty()) all.push_back(layout);
  constexpr std::pair<char, const char*> separators[] = {{';', "separated by semicolons"},
                                                         {'\t', "separated by tabulators"},
                                                         {'|', "separated by pipes"},
                                                         {' ', "separated by blanks"}};
  if (limits_.recognize)
    for (const auto& [mark, text] : separators)
      if (mark == format_.separator) all.emplace_back(text);
  if (format_.decimal == ',') all.emplace_back("decimal commas");
  for (std::size_t i = 0; i < comma_columns_.size(); ++i)
    if (comma_columns_[i]) all.push_back("decimal commas in " + qerr::quoted(header_[i]));
  if (std::any_of(cell_units_.begin(), cell_units_.end(), [](const auto& u) { return !u.empty(); }))
    all.emplace_back("units in the cells");
  if (format_.header_is_comment) all.emplace_back("a comment as header");
  if (format_.has_units) all.emplace_back("units in the row behind the header");
  if (!format_.has_header && source_.layout().labels().empty())
    all.emplace_back("no header: columns by number, 'column 1'");
  if (format_.preamble > 0)
    all.push_back(counted(static_cast<std::size_t>(format_.preamble), "line") + " before the header");
  if (empty_rows_ > 0) all.push_back(counted(empty_rows_, "empty row") + " at the end");
  if (left_out_ > 0) all.push_back(counted(left_out_, "line") + " of words behind a blank line left out");
  return joined(all);
}

std::vector<std::vector<std::string>> CsvReader::first_rows(std::size_t most) const {
  std::vector<std::vector<std::string>> rows;
  const char *begin = buffer_.data() + next_, *const last = buffer_.data() + end_;
  while (rows.size() < most && begin != last) {
    const char* const end = std::find(begin, last, '\n');
    if (end == last) break;
    if (!std::all_of(begin, end, [&](char c) { return is_blank(c) || separates(c); })) {
      rows.emplace_back();
      try {
        for (Cell& cell : cells_of(begin, end)) rows.back().push_back(std::move(cell.text));
      } catch (const Error&) {  // of a row with a fault, which `next` reports
        rows.pop_back();
        break;
      }
    }
    begin = end + 1;
  }
  return rows;
}

Place CsvReader::header_place(std::size_t column) const { return header_places_[column]; }

void CsvReader::choose(const std::vector<std::size_t>& columns, const std::vector<std::size_t>& texts) {
  chosen_ = columns;
  text_columns_ = texts;
  plan_.assign(header_.size(), -1);
  for (std::size_t i = 0; i < columns.size(); ++i) plan_[columns[i]] = static_cast<std::ptrdiff_t>(i);
  for (std::size_t i = 0; i < texts.size(); ++i) plan_[texts[i]] = -2 - static_cast<std::ptrdiff_t>(i);
  written_.assign(columns.size(), {});
  texts_.assign(texts.size(), {});
  text_cells_.assign(texts.size(), {});
}

int CsvReader::line() const {
  return static_cast<int>(std::min<std::int64_t>(line_, std::numeric_limits<int>::max()));
}

Place CsvReader::place_at(const char* cell) const {
  Place place{file(), line(), 1};
  advance(place, buffer_.data() + row_, cell);
  return place;
}

Place CsvReader::place(std::size_t chosen) const { return cell_place(chosen_[chosen]); }

Place CsvReader::cell_place(std::size_t column) const {
  const std::vector<Cell> cells = cells_of(buffer_.data() + row_, buffer_.data() + next_ - 1);
  return place_at(cells[column].begin);
}

std::string CsvReader::text(std::size_t chosen) const {
  return cells_of(buffer_.data() + row_, buffer_.data() + next_ - 1)[chosen_[chosen]].text;
}

/// Splits a record into its cells (RFC 4180): a quoted cell may contain separators and line ends, and a
/// doubled quotation mark is one.
std::vector<CsvReader::Cell> CsvReader::cells_of(const char* begin, const char* end) const {
  std::vector<Cell> cells;
  const char* p = begin;
  if (format_.separator == ' ')  // blanks at the ends separate nothing
    while (end != begin && is_blank(end[-1])) --end;
  while (true) {
    while (p != end && (format_.separator == ' ' ? is_blank(*p) : is_blank_in_cell(*p))) ++p;
    Cell cell{{}, p, p != end && *p == '"'};
    if (cell.quoted) {
      for (++p; p != end && (*p != '"' || (p + 1 != end && *++p == '"')); ++p) cell.text += *p;
      // p is after the closing quotation mark, or on it at the end of the record
      p += p != end && *p == '"';
      while (p != end && is_blank_in_cell(*p)) ++p;
      if (p != end && !separates(*p))
        throw Error(place_at(p), "", "text follows the closing quote", "",
                    "a quote within a cell is doubled");
    } else {
      while (p != end && !separates(*p)) ++p;
      cell.text.assign(cell.begin, p);
      while (!cell.text.empty() && is_blank(cell.text.back())) cell.text.pop_back();
      cell.text = without_text_mark(cell.text);
      if (const auto at = cell.text.find('\r'); at != std::string::npos)
        throw Error(place_at(cell.begin + at), "", "a carriage return without a line feed", "",
                    "end lines with LF or CR LF");
    }
    cells.push_back(std::move(cell));
    if (p == end) return cells;
    ++p;
  }
}

DecimalText WrittenNumbers::text() const {
  if (least_decimals > most_decimals) return {};
  int digits = 0;
  for (std::uint64_t n = largest; n > 0; n /= 10) ++digits;
  return {most_decimals, least_decimals, std::max(most_digits, digits)};
}

}  // namespace qerr
