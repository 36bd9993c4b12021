#include "input/log_samples.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "input/log_columns.hpp"
#include "input/read_sections.hpp"

namespace qerr {

StampReader::StampReader(const CsvReader& table, std::size_t column, std::size_t text, LogClock& clock)
    : table_(table),
      column_(column),
      text_(text),
      clock_(clock),
      unit_(time_unit(table.header()[column], table.header_place(column))) {}

double StampReader::operator()() {
  const std::string_view text = table_.chosen_text(text_);
  if (const auto seconds = clock_.seconds(text, unit_, written_)) return *seconds;
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

/// Index of the first column of this name.
std::optional<std::size_t> column_called(const CsvReader& table, const std::string& name) {
  const auto& header = table.header();
  const auto found = std::find_if(header.begin(), header.end(),
                                  [&](const std::string& cell) { return column_name(cell).name == name; });
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

class WideSamples : public LogSamples {
 public:
  WideSamples(std::unique_ptr<CsvReader> table, bool empty_stamps, LogClock& clock)
      : table_(std::move(table)),
        clock_(clock),
        empty_stamps_(empty_stamps),
        time_(column_called(*table_, "time")) {
    for (std::size_t i = 0; i < table_->header().size(); ++i)
      signals_.push_back({table_->header()[i], table_->header_place(i)});
  }

  const std::vector<LogHeader>& signals() const override { return signals_; }
  std::optional<std::size_t> time() const override { return time_; }

  void choose(const std::vector<std::size_t>& signals) override {
    if (time_) stamp_.emplace(*table_, *time_, 0, clock_);
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
  const ByteSource& source() const override { return table_->source(); }

 private:
  std::unique_ptr<CsvReader> table_;
  LogClock& clock_;
  bool empty_stamps_;
  std::optional<std::size_t> time_;
  std::vector<LogHeader> signals_;
  std::optional<StampReader> stamp_;
  std::optional<double> last_;
};

}  // namespace

std::unique_ptr<LogSamples> open_log(const std::string& path, const CsvLimits& limits, bool empty_stamps,
                                     LogClock& clock) {
  auto table = std::make_unique<CsvReader>(path, limits);
  if (column_called(*table, "signal") && column_called(*table, "value"))
    return read_long_log(std::move(table), clock);
  return std::make_unique<WideSamples>(std::move(table), empty_stamps, clock);
}

}  // namespace qerr
