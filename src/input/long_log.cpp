#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/input/read_log.hpp"

namespace qerr {

namespace {

struct Sample {
  double time, value;
  std::uint32_t signal;
  std::int32_t line;
};

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
      : LogSamples(table->file()), table_(std::move(table)) {
    time_ = 0;
    find_columns(reading);
    StampReader stamp(*table_, column_[time_text], time_text, signals_[0].meaning.unit, clock);
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
    for (const LogHeader& h : signals_) names.push_back(h.text);
    const std::vector<ColumnMeaning> meanings = column_meanings(names, reading);
    for (std::size_t i = 1; i < signals_.size(); ++i) signals_[i].meaning = meanings[i];
    if (index_.empty())
      throw Error({table_->file(), table_->line(), 1}, "", "the log has no rows", "only a header", "");
  }

  void choose(const std::vector<std::size_t>& signals) override {
    chosen_ = signals;
    std::vector<std::int64_t> place(signals_.size(), -1);
    for (std::size_t i = 0; i < signals.size(); ++i) {
      const auto& fault = known_[signals[i]].fault;
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
      LongSignal& signal = known_[chosen_[s.signal]];
      signal.line = line_ = s.line;
      signal.value = s.value;
    }
    return true;
  }

  int line() const override { return line_; }
  int line_of(std::size_t chosen) const override { return known_[chosen_[chosen]].line; }
  Place place(std::size_t chosen) const override { return {file_, known_[chosen_[chosen]].line, 1}; }
  std::string text(std::size_t chosen) const override { return shortest(known_[chosen_[chosen]].value); }
  DecimalText written(std::size_t chosen) const override { return known_[chosen_[chosen]].written.text(); }
  DecimalText written_time() const override { return written_time_; }
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
    if (!ordered_) all.push_back(file_ + ": its rows are not in the order of time; they are sorted by time");
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
        throw Error(table_->header_place(i), cell.name, "duplicate column", "", "keep one of them");
      if (k != time_text && !cell.unit.empty())
        throw Error(table_->header_place(i), table_->header()[i], "a unit of all signals", "",
                    "write it behind each signal's name, 'elbow.reference [deg]', or in a column 'unit'");
      found[k] = true;
      column_[k] = i;
    }
    if (!found[time_text])
      throw Error(table_->header_place(0), "", "rows of single signals need time stamps", "",
                  "add a column 'time [s]'");
    units_ = found[unit_text];
    const std::size_t stamp = column_[time_text];
    stamps_ = recognize_stamps(table_->file(), table_->header(), stamp,
                               first_cells(*table_, stamp, sampled_stamps), meanings[stamp]);
    signals_.push_back({table_->header()[stamp], table_->header_place(stamp), meanings[stamp]});
    known_.emplace_back();
  }

  std::uint32_t signal_of_row() {
    name_.assign(table_->chosen_text(signal_text));
    const auto [found, added] = index_.try_emplace(name_, static_cast<std::uint32_t>(signals_.size()));
    const std::string_view unit = units_ ? table_->chosen_text(unit_text) : std::string_view();
    if (added) {
      const Place place = table_->cell_place(column_[signal_text]);
      if (!unit.empty() && !column_name(name_).unit.empty())
        throw Error(place, name_, "the signal has a unit in its name and in the column 'unit'", "",
                    "keep one of them");
      signals_.push_back({unit.empty() ? name_ : name_ + " [" + std::string(unit) + ']', place, {}});
      known_.emplace_back().unit = unit;
    } else if (unit != known_[found->second].unit) {
      throw Error(table_->cell_place(column_[unit_text]), name_, "a signal must have one unit",
                  "'" + std::string(unit) + "' after '" + known_[found->second].unit + "'", "");
    }
    return found->second;
  }

  void add(double time, StampReader& stamp) {
    const std::uint32_t index = signal_of_row();
    LongSignal& signal = known_[index];
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
      signal.fault = Error(table_->cell_place(column_[value_text]), signals_[index].text,
                           text.empty() ? "the cell is empty" : "not a finite decimal number",
                           text.empty() ? "" : "'" + std::string(text) + "'",
                           "write a plain number, or leave the row out");
    else
      samples_.push_back({time, value, index, table_->line()});
  }

  std::unique_ptr<CsvReader> table_;
  std::size_t column_[4] = {};
  bool units_ = false, ordered_ = true;
  std::string name_, stamps_;
  std::unordered_map<std::string, std::uint32_t> index_;
  std::vector<LongSignal> known_;  // of each signal
  std::vector<Sample> samples_;
  std::size_t at_ = 0;
  int line_ = 0;
  DecimalText written_time_;
};

}  // namespace

std::unique_ptr<LogSamples> read_long_log(std::unique_ptr<CsvReader> table, const LogReading& reading,
                                          LogClock& clock) {
  return std::make_unique<LongSamples>(std::move(table), reading, clock);
}

namespace {

/// Stretches of consecutive rows, all of one length; when they exceed the memory limit, every second one is
/// dropped.
class Stretches {
 public:
  explicit Stretches(std::uint64_t most_values) : most_values_(most_values) {}

  void add(Eigen::ArrayXXd rows, std::vector<std::uint64_t> file_rows) {
    if (number_++ % every_ != 0) return;
    kept_.push_back({(number_ - 1) * stretch_rows, std::move(rows), std::move(file_rows)});
    const auto columns = static_cast<std::uint64_t>(kept_.front().rows.cols());
    if (kept_.size() < 4 || kept_.size() * columns * stretch_rows <= most_values_) return;
    every_ *= 2;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2) {
      if (i != count) std::swap(kept_[count], kept_[i]);
      ++count;
    }
    kept_.resize(count);
  }

  void move_to(Log& log) {
    Eigen::Index rows = 0, next = 0;
    for (const Stretch& s : kept_) rows += s.rows.rows();
    log.values.resize(rows, static_cast<Eigen::Index>(log.columns.size()));
    const bool gaps = !kept_.empty() && !kept_.back().file_rows.empty();
    for (Stretch& s : kept_) {
      for (Eigen::Index k = 0; gaps && k < s.rows.rows(); ++k)
        log.file_rows.push_back(s.file_rows.empty() ? s.first + static_cast<std::uint64_t>(k)
                                                    : s.file_rows[static_cast<std::size_t>(k)]);
      log.values.middleRows(next, s.rows.rows()) = s.rows;
      next += s.rows.rows();
      s.rows.resize(0, 0);
      if (every_ > 1) log.stretches.push_back(s.first);
    }
    if (every_ == 1) return;
    log.stretch_rows = static_cast<Eigen::Index>(stretch_rows);
    log.warnings.push_back(std::to_string(log.rows) + " rows: " + std::to_string(rows) +
                           " of them are used, in " + std::to_string(kept_.size()) +
                           " stretches spread evenly over the log");
  }

  static constexpr std::uint64_t stretch_rows = 16384;

 private:
  struct Stretch {
    std::uint64_t first = 0;
    Eigen::ArrayXXd rows;
    std::vector<std::uint64_t> file_rows;  // empty: from `first` on
  };
  std::uint64_t most_values_, number_ = 0, every_ = 1;
  std::vector<Stretch> kept_;
};

/// Makes columns of counts that are not whole positions of their joints.
void convert_fractions(Log& log, const Spec& spec) {
  const Transmission& t = spec.model.transmission;
  for (std::size_t c = 0; c < log.columns.size(); ++c) {
    LogColumn& column = log.columns[c];
    if (column.denominator == 1) continue;
    const auto i = static_cast<Eigen::Index>(column.index);
    const bool prismatic = spec.model.chain.independent[column.index].prismatic();
    const double count = t.coupling(i, i) * t.encoders[column.index].resolution;
    log.values.col(static_cast<Eigen::Index>(c)) *= count;
    const std::string n = std::to_string(column.denominator);
    log.warnings.push_back(log.file + ": " + column.header + ": not whole, but multiples of 1/" + n +
                           " count; read as '.measured'. If the encoder is interpolated, its resolution is " +
                           n + " times as fine, and so are its counts");
    column.signal = LogSignal::measured;
    column.unit = prismatic ? "m" : "rad";
    column.scale = {std::abs(count), 1, prismatic ? dimension::length : dimension::angle};
  }
}

}  // namespace

Log read_log(const LogFiles& files, const Spec& spec, std::uint64_t most_values,
             std::function<void(std::uint64_t, std::uint64_t)> progress) {
  LogReader reader(
      files, spec,
      {.block_rows = static_cast<Eigen::Index>(Stretches::stretch_rows), .progress = std::move(progress)});
  Stretches stretches(most_values);
  for (Eigen::ArrayXXd rows; reader.next(rows);) stretches.add(std::move(rows), reader.file_rows());
  Log log = reader.log();
  stretches.move_to(log);
  convert_fractions(log, spec);
  return log;
}

/// A log whose columns are arrays of a program that calls qerr, such as Python: read where they are.

namespace {

constexpr const char* arrays_name = "(arrays)";
constexpr std::size_t most_written = 20000;  // values whose decimals are looked at: 2 ms a column

/// Decimals of a column, of values that are evenly spaced in it: those of arrays read from a text are the
/// text's, and tell how it was rounded.
DecimalText decimals_of(const LogArray& array) {
  WrittenNumbers written;
  const std::size_t step = std::max<std::size_t>(1, array.rows / most_written);
  for (std::size_t row = 0; row < array.rows; row += step) {
    if (!std::isfinite(array.at(row))) continue;
    double value = 0;
    const std::string text = shortest(array.at(row)) + '\n';
    read_number(text.data(), value, written);
  }
  return written.text();
}

class ArraySamples : public LogSamples {
 public:
  ArraySamples(const std::vector<LogArray>& arrays, const CsvLimits& limits, const LogReading& reading,
               LogClock& clock)
      : LogSamples(arrays_name), arrays_(arrays), limits_(limits), clock_(clock) {
    const std::vector<std::string> names = names_of(arrays);
    for (const LogArray& array : arrays)
      if (array.rows != arrays.front().rows)
        throw Error({arrays_name, 0, 0}, array.name, "the arrays must have equally many values",
                    std::to_string(array.rows) + " and " + std::to_string(arrays.front().rows),
                    "give signals of other rates as files");
    std::vector<ColumnMeaning> meanings = column_meanings(names, reading);
    time_ = find_stamps(names, meanings, [&](std::size_t i) { return texts_of(i, sampled_stamps); });
    if (time_) {
      stamps_ =
          recognize_stamps(arrays_name, names, *time_, texts_of(*time_, sampled_stamps), meanings[*time_]);
      unit_ = time_unit(meanings[*time_].unit, names[*time_], {arrays_name, 0, 0});
    }
    for (std::size_t i = 0; i < names.size(); ++i)
      signals_.push_back({names[i], {arrays_name, 0, 0}, std::move(meanings[i])});
  }

  void choose(const std::vector<std::size_t>& signals) override {
    chosen_ = signals;
    written_.clear();
    for (const std::size_t signal : signals) written_.push_back(decimals_of(arrays_[signal]));
    if (time_) written_time_ = decimals_of(arrays_[*time_]);
  }

  bool next(double& time, double* values) override {
    if (arrays_.empty() || row_ == arrays_.front().rows) return false;
    ++row_;
    for (std::size_t i = 0; i < chosen_.size(); ++i) values[i] = value_of(chosen_[i]);
    if (!time_) return true;
    const double stamp = unit_.in_si(value_of(*time_));
    if (std::isnan(stamp)) {
      time = stamp;
      return true;
    }
    if (std::abs(stamp) > physical_range(dimension::time).largest)
      refuse(*time_, "the number is too large", "give seconds");
    time = clock_.seconds(stamp);
    if (last_ && time < *last_)
      refuse(*time_, "time must not decrease, after " + shortest(clock_.origin() + *last_) + " s",
             "sort the rows by time");
    last_ = time;
    return true;
  }

  int line() const override { return static_cast<int>(row_); }
  Place place(std::size_t) const override { return {file(), line(), 0}; }
  std::string text(std::size_t chosen) const override {
    return shortest(arrays_[chosen_[chosen]].at(row_ - 1));
  }
  DecimalText written(std::size_t chosen) const override { return written_[chosen]; }
  DecimalText written_time() const override { return written_time_; }
  std::vector<std::string> first_texts(std::size_t signal) const override { return texts_of(signal, 1000); }
  std::vector<std::string> warnings() const override {
    return stamps_.empty() ? std::vector<std::string>{} : std::vector{stamps_};
  }

 private:
  std::vector<std::string> texts_of(std::size_t signal, std::size_t most) const {
    std::vector<std::string> texts;
    for (std::size_t row = 0; row < std::min(most, arrays_[signal].rows); ++row)
      texts.push_back(shortest(arrays_[signal].at(row)));
    return texts;
  }

  double value_of(std::size_t signal) const {
    const double value = arrays_[signal].at(row_ - 1);
    if (std::isinf(value)) refuse(signal, "not a finite number", "give nan where there is no value");
    if (std::isnan(value) && !limits_.empty_cells)
      refuse(signal, "the value is missing", "leave the row out" + limits_.empty_remedy);
    return value;
  }

  /// @throws Error with the row, from 1
  [[noreturn]] void refuse(std::size_t signal, const std::string& rule, const std::string& remedy) const {
    throw Error({arrays_name, line(), 0}, arrays_[signal].name, rule, shortest(arrays_[signal].at(row_ - 1)),
                remedy);
  }

  std::vector<LogArray> arrays_;
  CsvLimits limits_;
  LogClock& clock_;
  std::string stamps_;  // what was recognized of them
  Unit unit_;
  std::vector<DecimalText> written_;
  DecimalText written_time_;
  std::size_t row_ = 0;  // read
  std::optional<double> last_;
};

}  // namespace

std::unique_ptr<LogSamples> array_samples(const std::vector<LogArray>& arrays, const CsvLimits& limits,
                                          const LogReading& reading, LogClock& clock) {
  return std::make_unique<ArraySamples>(arrays, limits, reading, clock);
}

}  // namespace qerr
