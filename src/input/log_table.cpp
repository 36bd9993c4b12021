#include "input/log_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/read_sections.hpp"

namespace qerr {

LogTable::LogTable(const LogFiles& files, const LogReading& reading, const CsvLimits& limits)
    : missing_values_(reading.missing) {
  CsvLimits held = limits;
  held.empty_cells = missing_values_ != MissingValues::error;
  held.empty_remedy =
      "; --set log.missing=drop leaves out all such rows, --hold holds the last value of a column";
  const auto opened = [&](std::size_t i) {
    if (i < files.paths.size()) return open_log(files.paths[i], held, reading, *clock_);
    std::vector<std::unique_ptr<LogSamples>> one;
    one.push_back(array_samples(files.arrays, held, reading, *clock_));
    return one;
  };
  const std::size_t sources = files.paths.size() + !files.arrays.empty();
  for (std::size_t s = 0; s < sources; ++s)
    for (std::unique_ptr<LogSamples>& samples : opened(s)) {
      File file;
      file.samples = std::move(samples);
      const auto time = file.samples->time();
      const auto& signals = file.samples->signals();
      if (sources > 1 && !time)
        throw Error(signals[0].place, "", "files are joined by time: each needs time stamps", "",
                    "add a column 'time [s]'");
      for (std::size_t i = 0; i < signals.size(); ++i) {
        if (i == time && !files_.empty()) continue;
        header_.push_back(signals[i]);
        sources_.emplace_back(files_.size(), i);
      }
      const std::string name = file.samples->file();
      const bool of_the_last = !files_.empty() && files_.back().samples->file() == name;
      if (!of_the_last) file_ += (file_.empty() ? "" : ", ") + name;
      files_.push_back(std::move(file));
    }
}

void LogTable::choose(const std::vector<std::size_t>& columns, const std::vector<Joining>& joining) {
  std::vector<bool> of_readings(files_.size(), false);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& [f, signal] = sources_[columns[i]];
    if (files_[f].samples->time() != signal && joining[i] == Joining::held) of_readings[f] = true;
    Column column;
    column.file = f;
    column.joining = joining[i];
    column.time = files_[f].samples->time() == signal;
    if (!column.time) {
      column.index = files_[f].signals.size();
      files_[f].signals.push_back(signal);
      files_[f].columns.push_back(columns_.size());
      ++missing_;
    }
    columns_.push_back(column);
  }
  const bool any = contains(of_readings, true);
  for (std::size_t f = 0; f < files_.size(); ++f) {
    files_[f].samples->choose(files_[f].signals);
    files_[f].values.resize(files_[f].signals.size());
    files_[f].ended = files_.size() > 1 && files_[f].signals.empty();  // its stamps are no rows
    files_[f].interpolated = any && !of_readings[f] && missing_values_ != MissingValues::hold;
    for (const std::size_t c : files_[f].columns)
      if (files_[f].interpolated && columns_[c].joining == Joining::interpolated)
        columns_[c].between = std::make_shared<ColumnSamples>();
  }
}

void LogTable::read_row(File& file) {
  while (!file.pending && !file.ended) {
    file.ended = !file.samples->next(file.time, file.values.data());
    file.pending = !file.ended && !std::isnan(file.time);
    if (!file.ended && !file.pending) ++rows_, ++left_out_, ++unstamped_;
  }
}

bool LogTable::next(double* values, std::ptrdiff_t stride) {
  while (true) {
    const File* first = nullptr;
    for (File& file : files_) {
      if (file.interpolated) continue;
      read_row(file);
      if (file.pending && (!first || file.time < first->time)) first = &file;
    }
    if (!first) {
      if (rows_ == left_out_ && left_out_ + dropped_ > 0) refuse_incomplete_rows();
      if (rows_ == left_out_ && unenclosed_ > 0)
        throw Error({file_, 0, 0}, "", "no reading lies between two samples of the reference", "",
                    "stamp both files with one clock, or hold the last values with --hold");
      return false;
    }
    const double time = first->time;
    ++rows_;
    bool enclosed = true;
    for (File& file : files_)
      if (file.interpolated)
        enclosed = interpolate(file, time) && enclosed;
      else if (file.pending && file.time == time)
        take(file);
    if (!enclosed) {
      ++unenclosed_, --rows_;
      for (Column& c : columns_)
        if (c.last_row > rows_) --c.samples, c.last_row = rows_;
      continue;
    }
    if (missing_values_ == MissingValues::drop && is_incomplete()) {
      ++left_out_;
      continue;
    }
    if (missing_ > 0) {
      ++dropped_, --rows_;
      for (Column& c : columns_) c.samples = 0;
      continue;
    }
    for (const Column& c : columns_) {
      *values = c.time ? time : c.value;
      values += stride;
    }
    return true;
  }
}

void LogTable::take(File& file) {
  file.pending = false;
  for (std::size_t i = 0; i < file.values.size(); ++i) {
    if (std::isnan(file.values[i])) continue;
    Column& c = columns_[file.columns[i]];
    if (std::isnan(c.value)) --missing_;
    c.value = file.values[i];
    c.line = file.samples->line_of(i);
    if (c.last_row > 0) c.longest_hold = std::max(c.longest_hold, rows_ - c.last_row);
    c.last_row = rows_;
    ++c.samples;
  }
}

namespace {

/// Value at a time between four samples or fewer, of the polynomial through those that no turn separates from
/// the time; NaN where it is not between them, in a gap, or where the signal starts again after a turn.
double interpolated(std::span<const TimedValue> samples, double time) {
  constexpr double gap = 3, jump = 20;  // times the steps beside (convention)
  const auto at_or_behind =
      std::find_if(samples.begin(), samples.end(), [&](const TimedValue& s) { return s.time >= time; });
  if (at_or_behind == samples.end()) return std::nan("");
  const auto b = static_cast<std::size_t>(at_or_behind - samples.begin());
  if (samples[b].time == time) return samples[b].value;
  if (b == 0) return std::nan("");
  const auto step = [&](std::size_t i) { return std::abs(samples[i].value - samples[i - 1].value); };
  double longest = 0, least_step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (i != b) longest = std::max(longest, samples[i].time - samples[i - 1].time);
    least_step = std::min(least_step, step(i));
  }
  const auto turns = [&](std::size_t i) {
    return samples.size() > 2 && step(i) > jump * least_step &&
           2 * step(i) > std::max(std::abs(samples[i].value), std::abs(samples[i - 1].value));
  };
  if (turns(b) || (longest > 0 && samples[b].time - samples[b - 1].time > gap * longest)) return std::nan("");
  if (step(b) == 0) return samples[b].value;  // it rests, or the sensor stands still
  std::size_t first = b - 1, end = b + 1;
  while (first > 0 && !turns(first)) --first;
  while (end < samples.size() && !turns(end)) ++end;
  double sum = 0;
  for (std::size_t i = first; i < end; ++i) {
    double weight = 1;
    for (std::size_t k = first; k < end; ++k)
      if (k != i) weight *= (time - samples[k].time) / (samples[i].time - samples[k].time);
    sum += weight * samples[i].value;
  }
  return sum;
}

}  // namespace

/// The values of a file's signals at a time.
/// @returns whether samples enclose it
bool LogTable::interpolate(File& file, double time) {
  const auto needs_more = [&](const Column& c) { return c.around.size() < 4 || c.around[2].time <= time; };
  const auto of_file = [&](std::size_t i) -> Column& { return columns_[file.columns[i]]; };
  for (std::size_t i = 0; i < file.columns.size(); ++i) {
    Column& c = of_file(i);
    while (needs_more(c) && !file.ended) {
      read_row(file);
      if (!file.pending) break;
      file.pending = false;
      for (std::size_t k = 0; k < file.columns.size(); ++k) {
        if (std::isnan(file.values[k])) continue;
        std::deque<TimedValue>& around = of_file(k).around;
        // Of two values at one time the last one holds.
        const bool again = !around.empty() && around.back().time == file.time;
        if (again) around.pop_back();
        around.push_back({file.time, file.values[k]});
        if (const auto& all = of_file(k).between; all && !again) {
          all->time.push_back(file.time);
          all->value.push_back(file.values[k]);
        }
      }
    }
  }
  bool enclosed = true;
  for (std::size_t i = 0; i < file.columns.size(); ++i) {
    Column& c = of_file(i);
    while (c.around.size() > 4 && c.around[2].time <= time) c.around.pop_front();
    std::array<TimedValue, 4> four;
    const auto n = static_cast<std::ptrdiff_t>(std::min<std::size_t>(4, c.around.size()));
    std::copy_n(c.around.begin(), n, four.begin());
    const auto samples = std::span(four).first(static_cast<std::size_t>(n));
    double value = interpolated(samples, time);
    if (std::isnan(value) && n > 0 && c.joining == Joining::extended)
      value = time < samples.front().time ? samples.front().value : samples.back().value;
    enclosed = enclosed && !std::isnan(value);
    if (std::isnan(value)) continue;
    between_samples_ = between_samples_ || std::none_of(samples.begin(), samples.end(),
                                                        [&](const TimedValue& x) { return x.time == time; });
    if (std::isnan(c.value)) --missing_;
    c.value = value;
    c.line = file.samples->line_of(i);
    c.last_row = rows_;
    ++c.samples;
  }
  return enclosed;
}

/// Whether a signal has no value of its own in the present row.
bool LogTable::is_incomplete() const {
  return std::any_of(columns_.begin(), columns_.end(),
                     [&](const Column& c) { return !c.time && c.last_row != rows_; });
}

void LogTable::refuse_incomplete_rows() const {
  std::string silent;
  for (const File& file : files_)
    for (std::size_t i = 0; i < file.signals.size(); ++i)
      if (std::isnan(columns_[file.columns[i]].value))
        silent += (silent.empty() ? "'" : ", '") + file.samples->signals()[file.signals[i]].text + "'";
  throw Error({file_, 0, 0}, "", "no row in which every signal has a value",
              silent.empty() ? "" : "none of " + silent,
              silent.empty() ? "'missing: hold' holds the last values"
                             : "leave out the signals that were not recorded");
}

Place LogTable::last_line() const { return {files_[0].samples->file(), files_[0].samples->line(), 1}; }

Place LogTable::place(std::size_t chosen) const {
  const Column& c = columns_[chosen];
  const LogSamples& samples = *files_[c.file].samples;
  if (samples.line_of(c.index) == c.line) return samples.place(c.index);
  return {samples.file(), c.line, 1};  // held since an earlier row, which is gone
}

std::string LogTable::text(std::size_t chosen) const {
  const Column& c = columns_[chosen];
  const LogSamples& samples = *files_[c.file].samples;
  return samples.line_of(c.index) == c.line ? samples.text(c.index) : shortest(c.value);
}

DecimalText LogTable::written(std::size_t chosen) const {
  const Column& c = columns_[chosen];
  const LogSamples& samples = *files_[c.file].samples;
  return c.time ? samples.written_time() : samples.written(c.index);
}

std::uint64_t LogTable::position() const {
  std::uint64_t sum = 0;
  for (const File& file : files_)
    if (!file.signals.empty()) sum += file.samples->position();
  return sum;
}

std::uint64_t LogTable::size() const {
  std::uint64_t sum = 0;
  for (const File& file : files_) {
    if (file.signals.empty()) continue;
    if (file.samples->size() == 0) return 0;
    sum += file.samples->size();
  }
  return sum;
}

std::vector<std::string> LogTable::warnings() const {
  std::vector<std::string> all;
  if (!clock_->remark().empty()) all.push_back(file_ + ": stamps: " + clock_->remark());
  for (const File& file : files_)
    for (std::string& warning : file.samples->warnings()) all.push_back(std::move(warning));
  if (dropped_ > 0)
    all.push_back(file_ + ": " + counted(dropped_, "row") +
                  " dropped at the beginning, before every signal has a value");
  std::string between;
  for (const File& file : files_)
    if ((between_samples_ || unenclosed_ > 0) && file.interpolated && !file.signals.empty())
      between += (between.empty() ? "" : ", ") + file.samples->name();
  if (!between.empty())
    all.push_back(between + ": interpolated at the stamps of the encoders" +
                  (unenclosed_ == 0 ? ""
                                    : "; " + counted(unenclosed_, "row") +
                                          " left out, before, behind or in gaps of its samples"));
  if (missing_values_ == MissingValues::drop) {
    if (left_out_ > 0)
      all.push_back(file_ + ": " + std::to_string(left_out_) + " of " + counted(rows_, "row") +
                    " left out, in which a signal has no value: " + incomplete_columns());
    return all;
  }
  for (const File& file : files_)
    for (std::size_t i = 0; i < file.signals.size(); ++i) {
      const Column& c = columns_[file.columns[i]];
      const std::uint64_t held = rows_ - c.last_row;
      // A signal recorded at a rate of its own pauses by less than two of its intervals.
      if (held > 2 * c.longest_hold)
        all.push_back(file.samples->name() + ": " + file.samples->signals()[file.signals[i]].text + " ends " +
                      counted(held, "row") +
                      " before the log does; its last value is held: cut the log there if it went on moving");
    }
  const std::string held = incomplete_columns();
  if (!held.empty())
    all.push_back(file_ + ": held between their samples, and late there if the robot moves: " + held);
  return all;
}

/// The columns that have no value of their own in some rows, with the number of these rows.
std::string LogTable::incomplete_columns() const {
  std::string held =
      unstamped_ > 0 ? "time in " + std::to_string(unstamped_) + " of " + counted(rows_, "row") : "";
  for (const File& file : files_)
    for (std::size_t i = 0; i < file.signals.size(); ++i) {
      const Column& c = columns_[file.columns[i]];
      if (c.samples + unstamped_ == rows_) continue;
      held += (held.empty() ? "" : ", ") + file.samples->signals()[file.signals[i]].text + " in " +
              std::to_string(rows_ - unstamped_ - c.samples) + " of " + counted(rows_, "row");
    }
  return held;
}

}  // namespace qerr
