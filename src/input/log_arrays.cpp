#include <algorithm>
#include <cmath>

#include "core/physical_range.hpp"
#include "core/text.hpp"
#include "input/log_columns.hpp"
#include "input/log_samples.hpp"

/// A log whose columns are arrays of a program that calls qerr, such as Python: read where they are.
namespace qerr {

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
      : arrays_(arrays), limits_(limits), clock_(clock) {
    std::vector<std::string> names;
    for (const LogArray& array : arrays) names.push_back(array.name);
    for (const LogArray& array : arrays)
      if (array.rows != arrays.front().rows)
        throw Error({{arrays_name, 0, 0},
                     array.name,
                     "the arrays must have equally many values",
                     std::to_string(array.rows) + " and " + std::to_string(arrays.front().rows),
                     "give signals of other rates as files"});
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

  const std::vector<LogHeader>& signals() const override { return signals_; }
  std::optional<std::size_t> time() const override { return time_; }

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
  int line_of(std::size_t) const override { return line(); }
  Place place(std::size_t) const override { return {file(), line(), 0}; }
  std::string text(std::size_t chosen) const override {
    return shortest(arrays_[chosen_[chosen]].at(row_ - 1));
  }
  DecimalText written(std::size_t chosen) const override { return written_[chosen]; }
  DecimalText written_time() const override { return written_time_; }
  std::vector<std::string> first_texts(std::size_t signal) const override { return texts_of(signal, 1000); }
  std::string file() const override { return arrays_name; }
  std::uint64_t size() const override { return 0; }
  std::uint64_t position() const override { return 0; }
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
    throw Error({{arrays_name, line(), 0},
                 arrays_[signal].name,
                 rule,
                 shortest(arrays_[signal].at(row_ - 1)),
                 remedy});
  }

  std::vector<LogArray> arrays_;
  CsvLimits limits_;
  LogClock& clock_;
  std::string stamps_;  // what was recognized of them
  std::optional<std::size_t> time_;
  Unit unit_;
  std::vector<LogHeader> signals_;
  std::vector<std::size_t> chosen_;
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
