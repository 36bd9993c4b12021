#include "input/joined_log.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Index of the column of this name, with any unit.
std::optional<std::size_t> find_name(const CsvReader& table, std::string_view name) {
  const auto& header = table.header();
  for (std::size_t i = 0; i < header.size(); ++i)
    if (column_name(header[i]).name == name) return i;
  return std::nullopt;
}

}  // namespace

bool is_long_format(const CsvReader& table) {
  return find_name(table, "time") && find_name(table, "signal") && find_name(table, "value");
}

void JoinedLog::add(CsvReader& table, bool timed) {
  const auto time = find_name(table, "time");
  if (!time && timed)
    throw Error({table.header_place(0), "", "several files are joined by time, and this one has none", "",
                 "add a column 'time [s]', or join the tables yourself"});
  if (time) add_time(table, *time);
  is_long_format(table) ? add_long(table, *time) : add_wide(table, time);
}

/// Enters the column of time, once, and the factor of this table's unit.
std::size_t JoinedLog::add_time(const CsvReader& table, std::size_t place) {
  const std::string& header = table.header()[place];
  const std::string name = column_name(header).unit;
  std::string why;
  const auto unit = parse_unit(name.empty() ? "s" : name, why);
  if (!unit || unit->dimension != dimension::time)
    throw Error({table.header_place(place), header, "the column has the wrong unit", "'" + name + "'",
                 "use s or a unit of that kind"});
  if (!time_) {
    unit_ = *unit;
    time_ = add_column(header, 0, table.header_place(place));
    columns_[*time_].is_time = true;
  }
  factor_ = unit->in_si(1) / unit_.in_si(1);
  return *time_;
}

std::size_t JoinedLog::add_column(const std::string& header, std::size_t stamps, const Place& place) {
  header_.push_back(header);
  columns_.push_back({.stamps = stamps, .place = place});
  return columns_.size() - 1;
}

std::size_t JoinedLog::new_stamps(const std::string& file) {
  stamps_.emplace_back().file = file;
  return stamps_.size() - 1;
}

/// The time of a cell, which may not be before the one before it.
double JoinedLog::time_of(const std::string& cell, const Place& place, std::size_t stamps,
                          const std::string& header) {
  double time = 0;
  if (!CsvReader::read_number(cell, time, columns_[*time_].written))
    throw Error({place, header, "not a finite decimal number", "'" + cell + "'",
                 "time is a number, such as seconds from the start or since 1970"});
  time *= factor_;
  const std::vector<double>& times = stamps_[stamps].times;
  if (!times.empty() && time < times.back())
    throw Error({place, header, "time must not decrease within a signal, after " + shortest(times.back()),
                 "'" + cell + "'", "sort the rows by time"});
  return time;
}

/// Appends the number of a cell; the first fault is kept, since the column may not be chosen.
void JoinedLog::store(Column& column, const std::string& header, const std::string& cell,
                      const Place& place) const {
  double value = std::numeric_limits<double>::quiet_NaN();
  const bool held = hold_ && cell.empty();
  if (!held && !CsvReader::read_number(cell, value, column.written) && !column.fault)
    column.fault =
        Error({place, header, cell.empty() ? "the cell is empty" : "not a finite decimal number",
               cell.empty() ? "" : "'" + cell + "'",
               cell.empty() ? "write a number, or hold the last one: --hold" : "write a plain number"});
  column.values.push_back(value);
}

void JoinedLog::add_wide(CsvReader& table, std::optional<std::size_t> time) {
  const std::size_t stamps = new_stamps(table.file());
  std::vector<std::size_t> of_cell(table.header().size());
  for (std::size_t i = 0; i < of_cell.size(); ++i)
    if (i != time) of_cell[i] = add_column(table.header()[i], stamps, table.header_place(i));
  std::vector<std::string> cells;
  std::vector<Place> places;
  while (table.next_texts(cells, places)) {
    Stamps& s = stamps_[stamps];
    const auto row = static_cast<double>(s.times.size());
    s.times.push_back(time ? time_of(cells[*time], places[*time], stamps, table.header()[*time]) : row);
    s.lines.push_back(static_cast<std::uint32_t>(table.line()));
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (i != time) store(columns_[of_cell[i]], table.header()[i], cells[i], places[i]);
  }
}

void JoinedLog::add_long(CsvReader& table, std::size_t time) {
  const std::size_t signal = *find_name(table, "signal"), value = *find_name(table, "value");
  const auto unit = find_name(table, "unit");
  std::map<std::string, std::size_t> column_of;
  std::vector<std::string> cells;
  std::vector<Place> places;
  double before = -std::numeric_limits<double>::infinity();
  bool sorted = true;
  while (table.next_texts(cells, places)) {
    std::string name = cells[signal];
    if (unit && !cells[*unit].empty()) name += " [" + cells[*unit] + "]";
    auto found = column_of.find(name);
    if (found == column_of.end())
      found = column_of.emplace(name, add_column(name, new_stamps(table.file()), places[signal])).first;
    Column& column = columns_[found->second];
    const double stamp = time_of(cells[time], places[time], column.stamps, table.header()[time]);
    sorted = sorted && stamp >= before;
    before = stamp;
    stamps_[column.stamps].times.push_back(stamp);
    stamps_[column.stamps].lines.push_back(static_cast<std::uint32_t>(table.line()));
    store(column, name, cells[value], places[value]);
  }
  if (!sorted) sorted_.push_back(table.file());
}

void JoinedLog::choose(const std::vector<std::size_t>& columns) {
  chosen_ = columns;
  std::vector<bool> kept(columns_.size(), false);
  for (const std::size_t c : columns) {
    const Column& column = columns_[c];
    if (column.fault) throw *column.fault;
    kept[c] = true;
    if (!column.is_time) stamps_[column.stamps].used = true;
  }
  for (std::size_t c = 0; c < columns_.size(); ++c)
    if (!kept[c]) columns_[c].values = {};
}

bool JoinedLog::next(double* values, std::ptrdiff_t stride) {
  while (true) {
    now_ = std::numeric_limits<double>::infinity();
    for (const Stamps& s : stamps_)
      if (s.used && s.next < s.times.size()) now_ = std::min(now_, s.times[s.next]);
    if (std::isinf(now_)) return false;
    std::vector<std::size_t> first;
    for (Stamps& s : stamps_) {
      first.push_back(s.next);
      while (s.used && s.next < s.times.size() && s.times[s.next] == now_) ++s.next;
    }
    bool complete = true;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      Column& column = columns_[chosen_[i]];
      if (!column.is_time)
        for (std::size_t k = first[column.stamps]; k < stamps_[column.stamps].next; ++k)
          if (!std::isnan(column.values[k])) column.last = column.values[k];
      const double value = column.is_time ? now_ : column.last;
      complete = complete && !std::isnan(value);
      values[static_cast<std::ptrdiff_t>(i) * stride] = value;
    }
    if (complete) return true;
    ++dropped_;
  }
}

Place JoinedLog::place(std::size_t chosen) const {
  const Column& column = columns_[chosen_[chosen]];
  if (column.is_time) return {column.place.file, 0, 0};
  const Stamps& s = stamps_[column.stamps];
  return {s.file, s.next == 0 ? 0 : static_cast<int>(s.lines[s.next - 1]), 1};
}

std::string JoinedLog::text(std::size_t chosen) const {
  const Column& column = columns_[chosen_[chosen]];
  return shortest(column.is_time ? now_ : column.last);
}

DecimalText JoinedLog::written(std::size_t chosen) const { return columns_[chosen_[chosen]].written.text(); }

std::vector<std::string> JoinedLog::warnings() const {
  std::vector<std::string> all;
  for (const std::string& file : sorted_)
    all.push_back(file + ": the signals follow one another; their rows are sorted by time");
  if (dropped_ > 0)
    all.push_back(counted(dropped_, "row") + " before the first value of every signal " +
                  (dropped_ == 1 ? "is" : "are") + " not used");
  return all;
}

}  // namespace qerr
