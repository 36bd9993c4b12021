#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "input/log_samples.hpp"
#include "input/read_sections.hpp"

namespace qerr {

namespace {

struct Sample {
  double time, value;
  std::uint32_t signal;
  std::int32_t line;
};

/// What is known of one signal of a long file.
struct LongSignal {
  WrittenNumbers written;
  std::string unit;                                        // of the column `unit`
  double last = -std::numeric_limits<double>::infinity();  // time stamp [s]
  std::optional<Error> fault;                              // matters if the signal is chosen
  int line = 0;                                            // of the sample that was returned last
  double value = 0;
};

class LongSamples : public LogSamples {
 public:
  LongSamples(std::unique_ptr<CsvReader> table, const LogReading& reading, LogClock& clock)
      : table_(std::move(table)) {
    find_columns(reading);
    StampReader stamp(*table_, column_[time_text], time_text, headers_[0].meaning.unit, clock);
    std::vector<std::size_t> texts{column_[time_text], column_[signal_text], column_[value_text]};
    if (units_) texts.push_back(column_[unit_text]);
    table_->choose({}, texts);
    double last = -std::numeric_limits<double>::infinity();
    while (table_->next(nullptr)) {
      const double time = stamp();
      add(time, stamp);
      ordered_ = ordered_ && time >= last;
      last = time;
    }
    written_time_ = stamp.written();
    std::vector<std::string> names;
    for (const LogHeader& h : headers_) names.push_back(h.text);
    const std::vector<ColumnMeaning> meanings = column_meanings(names, reading);
    for (std::size_t i = 1; i < headers_.size(); ++i) headers_[i].meaning = meanings[i];
    if (index_.empty())
      throw Error({{table_->file(), table_->line(), 1}, "", "the log has no rows", "only a header", ""});
  }

  const std::vector<LogHeader>& signals() const override { return headers_; }
  std::optional<std::size_t> time() const override { return 0; }

  void choose(const std::vector<std::size_t>& signals) override {
    chosen_ = signals;
    std::vector<std::int64_t> place(headers_.size(), -1);
    for (std::size_t i = 0; i < signals.size(); ++i) {
      const auto& fault = signals_[signals[i]].fault;
      if (fault) throw Error(*fault);
      place[signals[i]] = static_cast<std::int64_t>(i);
    }
    std::erase_if(samples_, [&](const Sample& s) { return place[s.signal] < 0; });
    for (Sample& s : samples_) s.signal = static_cast<std::uint32_t>(place[s.signal]);
    // Stable: of two values with one stamp the later row holds.
    if (!ordered_)
      std::stable_sort(samples_.begin(), samples_.end(),
                       [](const Sample& a, const Sample& b) { return a.time < b.time; });
  }

  bool next(double& time, double* values) override {
    if (at_ == samples_.size()) return false;
    std::fill_n(values, chosen_.size(), std::numeric_limits<double>::quiet_NaN());
    time = samples_[at_].time;
    for (; at_ < samples_.size() && samples_[at_].time == time; ++at_) {
      const Sample& s = samples_[at_];
      values[s.signal] = s.value;
      LongSignal& signal = signals_[chosen_[s.signal]];
      signal.line = line_ = s.line;
      signal.value = s.value;
    }
    return true;
  }

  int line() const override { return line_; }
  int line_of(std::size_t chosen) const override { return signals_[chosen_[chosen]].line; }
  Place place(std::size_t chosen) const override {
    return {table_->file(), signals_[chosen_[chosen]].line, 1};
  }
  std::string text(std::size_t chosen) const override { return shortest(signals_[chosen_[chosen]].value); }
  DecimalText written(std::size_t chosen) const override { return signals_[chosen_[chosen]].written.text(); }
  DecimalText written_time() const override { return written_time_; }
  std::string file() const override { return table_->file(); }
  std::uint64_t size() const override { return table_->source().size(); }
  std::uint64_t position() const override { return table_->source().position(); }
  std::vector<std::string> first_texts(std::size_t signal) const override {
    constexpr std::size_t most = 1000;
    std::vector<std::string> texts;
    for (const Sample& s : samples_)
      if (s.signal == signal && texts.size() < most) texts.push_back(shortest(s.value));
    return texts;
  }
  std::vector<std::string> warnings() const override {
    std::vector<std::string> all = format_warnings(*table_, stamps_);
    if (!ordered_)
      all.push_back(table_->file() + ": its rows are not in the order of time; they are sorted by time");
    return all;
  }

 private:
  enum Text : std::size_t { time_text, signal_text, value_text, unit_text };

  void find_columns(const LogReading& reading) {
    static const std::string names[] = {"time", "signal", "value", "unit"};
    std::string others;
    bool found[4] = {};
    std::vector<ColumnMeaning> meanings = column_meanings(table_->header(), reading);
    const auto time = find_stamps(table_->header(), meanings,
                                  [&](std::size_t i) { return first_cells(*table_, i, sampled_stamps); });
    for (std::size_t i = 0; i < table_->header().size(); ++i) {
      ColumnName cell = column_name(table_->header()[i]);
      if (i == time) cell.name = names[time_text];
      const auto* const name = std::find(std::begin(names), std::end(names), cell.name);
      const auto k = static_cast<std::size_t>(name - std::begin(names));
      if (k == 4) continue;
      if (found[k])
        throw Error({table_->header_place(i), cell.name, "duplicate column", "", "keep one of them"});
      if (k != time_text && !cell.unit.empty())
        throw Error({table_->header_place(i), table_->header()[i], "a unit of all signals", "",
                     "write it behind each signal's name, 'elbow.reference [deg]', or in a column 'unit'"});
      found[k] = true;
      column_[k] = i;
    }
    if (!found[time_text])
      throw Error({table_->header_place(0), "", "rows of single signals need time stamps", "",
                   "add a column 'time [s]'"});
    units_ = found[unit_text];
    const std::size_t stamp = column_[time_text];
    stamps_ = recognize_stamps(table_->file(), table_->header(), stamp,
                               first_cells(*table_, stamp, sampled_stamps), meanings[stamp]);
    headers_.push_back({table_->header()[stamp], table_->header_place(stamp), meanings[stamp]});
    signals_.emplace_back();
  }

  /// The signal of the last row.
  std::uint32_t signal_of_row() {
    name_.assign(table_->chosen_text(signal_text));
    const auto [found, added] = index_.try_emplace(name_, static_cast<std::uint32_t>(headers_.size()));
    const std::string_view unit = units_ ? table_->chosen_text(unit_text) : std::string_view();
    if (added) {
      const Place place = table_->cell_place(column_[signal_text]);
      if (!unit.empty() && !column_name(name_).unit.empty())
        throw Error({place, name_, "the signal has a unit in its name and in the column 'unit'", "",
                     "keep one of them"});
      headers_.push_back({unit.empty() ? name_ : name_ + " [" + std::string(unit) + ']', place, {}});
      signals_.emplace_back().unit = unit;
    } else if (unit != signals_[found->second].unit) {
      throw Error({table_->cell_place(column_[unit_text]), name_, "a signal must have one unit",
                   "'" + std::string(unit) + "' after '" + signals_[found->second].unit + "'", ""});
    }
    return found->second;
  }

  void add(double time, StampReader& stamp) {
    const std::uint32_t index = signal_of_row();
    LongSignal& signal = signals_[index];
    if (signal.fault) return;
    if (time < signal.last) try {
        stamp.refuse_before(signal.last);
      } catch (const Error& e) {
        signal.fault = e;
        return;
      }
    signal.last = time;
    const std::string_view text = table_->chosen_text(value_text);
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    double value = 0;
    if (text.empty() || read_number(text.data() + plus, value, signal.written) != text.data() + text.size())
      signal.fault = Error({table_->cell_place(column_[value_text]), headers_[index].text,
                            text.empty() ? "the cell is empty" : "not a finite decimal number",
                            text.empty() ? "" : "'" + std::string(text) + "'",
                            "write a plain number, or leave the row out"});
    else
      samples_.push_back({time, value, index, table_->line()});
  }

  std::unique_ptr<CsvReader> table_;
  std::size_t column_[4] = {};
  bool units_ = false, ordered_ = true;
  std::string name_, stamps_;
  std::unordered_map<std::string, std::uint32_t> index_;
  std::vector<LogHeader> headers_;  // the time stamps first
  std::vector<LongSignal> signals_;
  std::vector<Sample> samples_;
  std::vector<std::size_t> chosen_;
  std::size_t at_ = 0;
  int line_ = 0;
  DecimalText written_time_;
};

}  // namespace

std::unique_ptr<LogSamples> read_long_log(std::unique_ptr<CsvReader> table, const LogReading& reading,
                                          LogClock& clock) {
  return std::make_unique<LongSamples>(std::move(table), reading, clock);
}

}  // namespace qerr
