#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"
#include "core/text.hpp"
#include "input/bag_file.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"

namespace qerr {
std::vector<std::string> format_warnings(const CsvReader& table, const std::string& stamps) {
  std::vector<std::string> all;
  if (const std::string format = table.recognized(); !format.empty())
    all.push_back(table.file() + ": " + format);
  if (!stamps.empty()) all.push_back(stamps);
  return all;
}

StampReader::StampReader(const CsvReader& table, std::size_t column, std::size_t text,
                         const std::string& unit, LogClock& clock, bool nanoseconds)
    : table_(table),
      column_(column),
      text_(text),
      nanoseconds_(nanoseconds),
      clock_(clock),
      unit_(time_unit(unit, table.header()[column], table.header_place(column))) {}

double StampReader::operator()() {
  const std::string_view text = table_.chosen_text(text_);
  if (nanoseconds_) {
    const auto whole = parse_number(text), part = parse_number(table_.chosen_text(text_ + 1));
    if (whole && part && *whole == std::floor(*whole) && *part == std::floor(*part) && *part >= 0 &&
        *part < 1e9 && std::abs(*whole) < 0x1p53)
      return clock_.seconds(
          TimeStamp{static_cast<std::int64_t>(*whole), static_cast<std::int64_t>(*part) * 1000000000});
    refuse("not whole seconds with nanoseconds behind them", "");
  }
  if (const auto seconds = clock_.seconds(text, unit_, written_)) return *seconds;
  std::string plain(text);
  if (make_decimal_notation(plain) || remove_thousands(plain)) {
    const std::size_t size = plain.size();
    plain += '\n';  // ends the number
    if (const auto seconds = clock_.seconds(std::string_view(plain).substr(0, size), unit_, written_))
      return *seconds;
  }
  const NumberAndUnit cell = number_and_unit(text, '.');
  std::string why;
  const auto of_cell = parse_number(cell.number);
  if (const auto unit_of_cell = parse_unit(cell.unit, why);
      of_cell && unit_of_cell && unit_of_cell->dimension == dimension::time)
    return clock_.seconds(unit_of_cell->in_si(*of_cell));
  if (text.empty()) refuse("the cell is empty", "write a plain number, or leave the row out");
  if (is_numeric(text, ','))
    refuse("a decimal comma, beside decimal points in other rows or columns",
           "write all numbers with one decimal mark");
  double number = 0;
  if (read_number(text.data(), number, written_) == text.data() + text.size())
    refuse("the number is too large", "");
  refuse("not a finite decimal number",
         "write a plain number, or the time in UTC as 2026-05-01T12:00:00.25Z");
}

void StampReader::refuse_before(double last) const {
  refuse("time must not decrease, after " + shortest(clock_.origin() + last) + " s", "sort the rows by time");
}

void StampReader::refuse(const std::string& rule, const std::string& remedy) const {
  const std::string text(table_.chosen_text(text_));
  throw Error(table_.cell_place(column_), table_.header()[column_], rule,
              text.empty() ? "" : "'" + text + "'", remedy);
}

namespace {

bool has_column(const CsvReader& table, const std::string& name) {
  const auto& header = table.header();
  return std::ranges::any_of(header, [&](const std::string& cell) { return column_name(cell).name == name; });
}

/// Whether stamps without a unit are Excel's dates: days since 1900, which pass slower than any clock in
/// seconds ticks.
bool are_serial_days(const std::vector<double>& stamps, const std::string& header) {
  constexpr double since_1970 = 25569, until_2100 = 73051;
  constexpr double fastest = 50e-6;  // [s] 20 kHz: smaller steps are none of seconds
  // MATLAB counts from the year 0.
  const double zero = stamps.front() > until_2100 ? 693960 : 0;
  if (stamps.front() - zero < since_1970 || stamps.back() - zero > until_2100) return false;
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    if (stamps[i] != stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  const bool date = header.starts_with("Dat") || header.starts_with("dat");
  return steps.size() > 1 && median(steps) > 0 && median(steps) < (date ? 1 : fastest);
}

/// Whether stamps count seconds since 1970, and are no counter of microseconds: its steps are larger.
bool are_epoch_seconds(const std::vector<double>& stamps) {
  constexpr double since_2001 = 1e9, until_2106 = 0x1p32, longest_step = 100;
  return stamps.front() >= since_2001 && stamps.back() < until_2106 &&
         stamps.back() - stamps.front() <= longest_step * static_cast<double>(stamps.size() - 1);
}

/// Whether the first cells of a column are stamps: each is one, they do not fall, and they change.
/// @param calendar  only dates and times of day count
bool are_stamps(const std::vector<std::string>& cells, bool calendar) {
  LogClock clock;
  WrittenNumbers written;
  std::optional<double> first, last;
  for (std::string text : cells) {
    if (text.empty() || (calendar && text.find(':') == std::string::npos)) return false;
    make_plain_number(text);
    auto seconds = parse_number(text);
    if (!seconds) seconds = clock.seconds(text, Unit{}, written);
    if (!seconds || (last && *seconds < *last)) return false;
    if (!first) first = seconds;
    last = seconds;
  }
  return last && *last > *first;
}

bool has_decimals(const std::vector<std::string>& cells) {
  return std::ranges::any_of(cells,
                             [](const std::string& c) { return c.find_first_of(".,") != std::string::npos; });
}

/// Whether the name of a column of seconds has one of nanoseconds behind it.
bool is_seconds_before(const std::string& seconds, const std::string& nanoseconds) {
  for (const auto& [s, ns] : {std::pair{"sec", "nanosec"},
                              {"secs", "nsecs"},
                              {"sec", "nsec"},
                              {"secs", "nanosecs"},
                              {"seconds", "nanoseconds"},
                              {"tv_sec", "tv_nsec"}}) {
    if (!seconds.ends_with(s) || !nanoseconds.ends_with(ns)) continue;
    const auto prefix = [](const std::string& name, const char* end) {
      return name.substr(0, name.size() - std::string_view(end).size());
    };
    if (prefix(seconds, s) == prefix(nanoseconds, ns)) return true;
  }
  return false;
}

class WideSamples : public LogSamples {
 public:
  WideSamples(std::unique_ptr<CsvReader> table, const LogReading& reading, LogClock& clock)
      : LogSamples(table->file()),
        table_(std::move(table)),
        clock_(clock),
        empty_stamps_(reading.missing == MissingValues::drop) {
    std::vector<ColumnMeaning> meanings = column_meanings(table_->header(), reading);
    const auto texts = [&](std::size_t i) { return first_cells(*table_, i, sampled_stamps); };
    time_ = find_stamps(table_->header(), meanings, texts);
    if (time_) {
      nanoseconds_ =
          nanoseconds_behind(table_->header(), *time_, [&](std::size_t i) { return first_texts(i); });
      if (nanoseconds_ && meanings[*nanoseconds_].mapped) nanoseconds_.reset();
      if (nanoseconds_) meanings[*time_].unit = "s";
      stamps_ = recognize_stamps(table_->file(), table_->header(), *time_, texts(*time_), meanings[*time_]);
      if (nanoseconds_)
        stamps_ += (stamps_.empty() ? table_->file() + ": the time stamps are seconds" : std::string()) +
                   " and nanoseconds of '" + table_->header()[*nanoseconds_] + "'";
    }
    if (const auto named = time_column(meanings); named && !time_)
      stamps_ = table_->file() + ": '" + table_->header()[*named] + "' does not rise in the first " +
                counted(sampled_stamps, "row") +
                ": it is not read as the time; if it is, write more decimals";
    for (std::size_t i = 0; i < table_->header().size(); ++i)
      signals_.push_back({table_->header()[i], table_->header_place(i), std::move(meanings[i])});
    if (nanoseconds_) signals_[*nanoseconds_].text.clear();  // a part of the stamps, no signal
  }

  void choose(const std::vector<std::size_t>& signals) override {
    std::vector<std::size_t> texts;
    if (time_) texts.push_back(*time_);
    if (nanoseconds_) texts.push_back(*nanoseconds_);
    if (time_)
      stamp_.emplace(*table_, *time_, 0, signals_[*time_].meaning.unit, clock_, nanoseconds_.has_value());
    table_->choose(signals, texts);
  }

  bool next(double& time, double* values) override {
    if (!table_->next(values)) return false;
    if (!stamp_) return true;
    if (empty_stamps_ && stamp_->is_empty()) {
      time = std::nan("");
      return true;
    }
    time = (*stamp_)();
    if (last_ && time < *last_) stamp_->refuse_before(*last_);
    last_ = time;
    return true;
  }

  int line() const override { return table_->line(); }
  Place place(std::size_t chosen) const override { return table_->place(chosen); }
  std::string text(std::size_t chosen) const override { return table_->text(chosen); }
  DecimalText written(std::size_t chosen) const override { return table_->written(chosen); }
  DecimalText written_time() const override { return stamp_ ? stamp_->written() : DecimalText{}; }
  std::uint64_t size() const override { return table_->source().size(); }
  std::uint64_t position() const override { return table_->source().position(); }
  std::vector<std::string> first_texts(std::size_t signal) const override {
    constexpr std::size_t most = 1000;
    return first_cells(*table_, signal, most);
  }
  std::vector<std::string> warnings() const override { return format_warnings(*table_, stamps_); }

 private:
  std::unique_ptr<CsvReader> table_;
  LogClock& clock_;
  std::string stamps_;  // what was recognized of them
  bool empty_stamps_;
  std::optional<std::size_t> nanoseconds_;
  std::optional<StampReader> stamp_;
  std::optional<double> last_;
};

}  // namespace

std::string unit_of_steps(const std::vector<double>& stamps) {
  std::vector<double> steps;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (stamps[i] != std::floor(stamps[i])) return "";
    if (i > 0 && stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  }
  if (steps.empty()) return "";
  const double step = median(steps);
  constexpr double fastest = 50e-6, slowest = 0.2;  // [s] 20 kHz and 5 Hz, convention
  std::string found;
  if (step == 1) return "";                        // a number of the row as well
  for (const double slow : {15., 30., 60., 120.})  // seconds, as of loggers of temperature
    if (step == slow) return "";
  for (const auto& [unit, size] : {std::pair{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}})
    if (step * size >= fastest && step * size <= slowest) found = found.empty() ? unit : "?";
  return found == "?" ? "" : found;
}

std::vector<std::string> first_cells(const CsvReader& table, std::size_t column, std::size_t most) {
  std::vector<std::string> cells;
  for (std::vector<std::string>& row : table.first_rows(most))
    if (column < row.size()) cells.push_back(std::move(row[column]));
  return cells;
}

std::optional<std::size_t> nanoseconds_behind(const std::vector<std::string>& header, std::size_t seconds,
                                              const ColumnTexts& texts) {
  if (seconds + 1 >= header.size()) return std::nullopt;
  if (is_seconds_before(header[seconds], header[seconds + 1])) return seconds + 1;
  if (header[seconds] != "column 1") return std::nullopt;
  const std::vector<std::string> whole = texts(seconds), part = texts(seconds + 1);
  constexpr double since_2001 = 1e9, until_2096 = 4e9, least_part = 1e5, second = 1e9;  // [s], [ns]
  std::size_t restarts = 0, large = 0;
  double last_s = 0, last_ns = 0;
  for (std::size_t i = 0; i < std::min(whole.size(), part.size()); ++i) {
    const auto s = parse_number(whole[i]), ns = parse_number(part[i]);
    if (!s || !ns || *s != std::floor(*s) || *ns != std::floor(*ns)) return std::nullopt;
    if (*s < since_2001 || *s > until_2096 || *ns < 0 || *ns >= second) return std::nullopt;
    if (*s < last_s || (*s == last_s && *ns < last_ns)) return std::nullopt;
    restarts += last_s > 0 && *s > last_s && *ns < last_ns;
    large += *ns >= least_part;
    last_s = *s, last_ns = *ns;
  }
  return restarts > 0 && 2 * large > whole.size() ? std::optional(seconds + 1) : std::nullopt;
}

std::optional<std::size_t> find_stamps(const std::vector<std::string>& header,
                                       const std::vector<ColumnMeaning>& columns, const ColumnTexts& texts) {
  const auto named = time_column(columns);
  if (named && (columns[*named].mapped || columns[*named].signal == "time")) return named;
  for (std::size_t i = 0; i + 1 < columns.size(); ++i)
    if (is_seconds_before(header[i], header[i + 1])) return i;
  if (std::ranges::any_of(columns, [](const auto& c) { return is_time_name(c.signal); })) return named;
  if (named && are_stamps(texts(*named), false)) return named;
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::string why;
    const auto unit = parse_unit(columns[i].unit, why);
    // Without a name the first column is the index of a table, of pandas say: of rows, or of seconds.
    const bool index = i == 0 && header[i].empty() && has_decimals(texts(i));
    const bool of_time = index || (unit && unit->dimension == dimension::time);
    if (columns[i].mapped || !are_stamps(texts(i), !of_time)) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

std::string recognize_stamps(const std::string& file, const std::vector<std::string>& names,
                             std::size_t column, std::vector<std::string> first_texts,
                             ColumnMeaning& meaning) {
  const std::string& header = names[column];
  const bool by_name = !meaning.mapped && measured_name(header).name != "time";
  std::string how;
  if (meaning.unit.empty()) {
    std::vector<double> stamps;
    bool calendar = false;
    WrittenNumbers written;
    for (std::string& text : first_texts) {
      if (text.empty()) continue;
      make_plain_number(text);
      double stamp = 0;
      text += '\n';
      if (read_number(text.data(), stamp, written) == text.data() + text.size() - 1)
        stamps.push_back(stamp);
      else
        calendar = true;
    }
    if (calendar && stamps.empty()) {
      meaning.unit = "s", how = "calendar time";
    } else if (!stamps.empty()) {
      if (const std::string unit = epoch_unit(stamps.front()); !unit.empty())
        meaning.unit = unit,
        how = unit + (unit == "100 ns" ? ", by their size" : " since 1970, by their size");
      else if (are_serial_days(stamps, header))
        meaning.unit = "d", how = stamps.front() < 1e5 ? "days since 1900, as Excel counts them"
                                                       : "days since the year 0, as MATLAB counts them";
      else if (const std::string program = program_time_unit(names); !program.empty())
        meaning.unit = program, how = program + ", as libfranka writes them";
      else if (const std::string named = unit_in_words(measured_name(header).name); by_name && !named.empty())
        meaning.unit = named;
      else if (are_epoch_seconds(stamps))
        meaning.unit = "s", how = "s since 1970, by their size";
      else if (const std::string step = unit_of_steps(stamps); !step.empty())
        meaning.unit = step, how = step + ", by their steps: write [s] behind the name if they are seconds";
    }
  }
  meaning.signal = "time";
  if (how.empty() && !by_name) return "";
  return file + ": '" + header + "' is read as the time stamps" +
         (how.empty() ? meaning.unit.empty() ? "" : ", in " + meaning.unit : ", in " + how);
}

std::vector<std::unique_ptr<LogSamples>> open_log(const std::string& path, const CsvLimits& limits,
                                                  const LogReading& reading, LogClock& clock) {
  if (is_bag(path)) return open_bag_log(path, reading, clock);
  CsvLimits any_format = limits;
  any_format.recognize = true;
  auto table = std::make_unique<CsvReader>(path, any_format);
  std::vector<std::unique_ptr<LogSamples>> one;
  if (has_column(*table, "signal") && has_column(*table, "value"))
    one.push_back(read_long_log(std::move(table), reading, clock));
  else
    one.push_back(std::make_unique<WideSamples>(std::move(table), reading, clock));
  return one;
}

}  // namespace qerr
