#include "input/log_samples.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/statistics.hpp"
#include "input/bag_file.hpp"
#include "input/log_columns.hpp"
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
                         const std::string& unit, LogClock& clock)
    : table_(table),
      column_(column),
      text_(text),
      clock_(clock),
      unit_(time_unit(unit, table.header()[column], table.header_place(column))) {}

double StampReader::operator()() {
  const std::string_view text = table_.chosen_text(text_);
  if (const auto seconds = clock_.seconds(text, unit_, written_)) return *seconds;
  std::string plain(text);
  if (make_decimal_notation(plain) || remove_thousands(plain)) {
    const std::size_t size = plain.size();
    plain += '\n';  // ends the number
    if (const auto seconds = clock_.seconds(std::string_view(plain).substr(0, size), unit_, written_))
      return *seconds;
  }
  if (text.empty()) refuse("the cell is empty", "write a plain number, or leave the row out");
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
  throw Error({table_.cell_place(column_), table_.header()[column_], rule,
               text.empty() ? "" : "'" + text + "'", remedy});
}

namespace {

/// Whether a header has a column of this name.
bool has_column(const CsvReader& table, const std::string& name) {
  const auto& header = table.header();
  return std::any_of(header.begin(), header.end(),
                     [&](const std::string& cell) { return column_name(cell).name == name; });
}

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
  if (step == 1) return "";  // a number of the row as well
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
        meaning.unit = unit, how = unit + " since 1970, by their size";
      else if (const std::string program = program_time_unit(names); !program.empty())
        meaning.unit = program, how = program + ", as libfranka writes them";
      else if (const std::string named = unit_in_words(measured_name(header).name); by_name && !named.empty())
        meaning.unit = named;
      else if (const std::string step = by_name ? unit_of_steps(stamps) : ""; !step.empty())
        meaning.unit = step, how = step + ", by their steps";
    }
  }
  meaning.signal = "time";
  if (how.empty() && !by_name) return "";
  return file + ": '" + header + "' is read as the time stamps" +
         (how.empty() ? meaning.unit.empty() ? "" : ", in " + meaning.unit : ", in " + how);
}

namespace {

class WideSamples : public LogSamples {
 public:
  WideSamples(std::unique_ptr<CsvReader> table, const LogReading& reading, LogClock& clock)
      : table_(std::move(table)), clock_(clock), empty_stamps_(reading.missing == MissingValues::drop) {
    std::vector<ColumnMeaning> meanings = column_meanings(table_->header(), reading);
    time_ = time_column(meanings);
    if (time_)
      stamps_ = recognize_stamps(table_->file(), table_->header(), *time_,
                                 first_cells(*table_, *time_, sampled_stamps), meanings[*time_]);
    for (std::size_t i = 0; i < table_->header().size(); ++i)
      signals_.push_back({table_->header()[i], table_->header_place(i), std::move(meanings[i])});
  }

  const std::vector<LogHeader>& signals() const override { return signals_; }
  std::optional<std::size_t> time() const override { return time_; }

  void choose(const std::vector<std::size_t>& signals) override {
    if (time_) stamp_.emplace(*table_, *time_, 0, signals_[*time_].meaning.unit, clock_);
    table_->choose(signals, time_ ? std::vector{*time_} : std::vector<std::size_t>{});
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
  int line_of(std::size_t) const override { return table_->line(); }
  Place place(std::size_t chosen) const override { return table_->place(chosen); }
  std::string text(std::size_t chosen) const override { return table_->text(chosen); }
  DecimalText written(std::size_t chosen) const override { return table_->written(chosen); }
  DecimalText written_time() const override { return stamp_ ? stamp_->written() : DecimalText{}; }
  std::string file() const override { return table_->file(); }
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
  std::optional<std::size_t> time_;
  std::vector<LogHeader> signals_;
  std::optional<StampReader> stamp_;
  std::optional<double> last_;
};

}  // namespace

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
