#include "input/log_table.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "input/read_sections.hpp"

namespace qerr {

LogTable::LogTable(const LogFiles& files, const LogReading& reading, const CsvLimits& limits)
    : missing_values_(reading.missing) {
  CsvLimits held = limits;
  held.empty_cells = missing_values_ != MissingValues::error;
  held.empty_remedy =
      "; --set log.missing=drop leaves out all such rows, --hold holds the last value of a column";
  for (const std::string& path : files.paths) {
    File file;
    file.samples = open_log(path, held, missing_values_ == MissingValues::drop, *clock_);
    const auto time = file.samples->time();
    const auto& signals = file.samples->signals();
    if (files.paths.size() > 1 && !time)
      throw Error({signals[0].place, "", "files are joined by time: each needs time stamps", "",
                   "add a column 'time [s]'"});
    for (std::size_t i = 0; i < signals.size(); ++i) {
      if (i == time && !files_.empty()) continue;
      header_.push_back(signals[i]);
      sources_.emplace_back(files_.size(), i);
    }
    file_ += (file_.empty() ? "" : ", ") + file.samples->source().name();
    files_.push_back(std::move(file));
  }
}

void LogTable::choose(const std::vector<std::size_t>& columns) {
  for (const std::size_t c : columns) {
    const auto& [f, signal] = sources_[c];
    Column column;
    column.file = f;
    column.time = files_[f].samples->time() == signal;
    if (!column.time) {
      column.index = files_[f].signals.size();
      files_[f].signals.push_back(signal);
      files_[f].columns.push_back(columns_.size());
      ++missing_;
    }
    columns_.push_back(column);
  }
  for (File& file : files_) {
    file.samples->choose(file.signals);
    file.values.resize(file.signals.size());
  }
}

bool LogTable::next(double* values, std::ptrdiff_t stride) {
  while (true) {
    const File* first = nullptr;
    for (File& file : files_) {
      while (!file.pending && !file.ended) {  // until a row with a stamp, or the end
        file.ended = !file.samples->next(file.time, file.values.data());
        file.pending = !file.ended && !std::isnan(file.time);
        if (!file.ended && !file.pending) ++rows_, ++left_out_, ++unstamped_;
      }
      if (file.pending && (!first || file.time < first->time)) first = &file;
    }
    if (!first) {
      if (rows_ == left_out_ && left_out_ + dropped_ > 0) refuse_incomplete_rows();
      return false;
    }
    const double time = first->time;
    ++rows_;
    for (File& file : files_)
      if (file.pending && file.time == time) take(file);
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

/// Holds the values that a file has read.
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
  throw Error({{file_, 0, 0},
               "",
               "no row in which every signal has a value",
               silent.empty() ? "" : "none of " + silent,
               silent.empty() ? "'missing: hold' holds the last values"
                              : "leave out the signals that were not recorded"});
}

Place LogTable::last_line() const {
  return {files_[0].samples->source().name(), files_[0].samples->line(), 1};
}

Place LogTable::place(std::size_t chosen) const {
  const Column& c = columns_[chosen];
  const LogSamples& samples = *files_[c.file].samples;
  if (samples.line_of(c.index) == c.line) return samples.place(c.index);
  return {samples.source().name(), c.line, 1};  // held since an earlier row, which is gone
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
  for (const File& file : files_) sum += file.samples->source().position();
  return sum;
}

std::uint64_t LogTable::size() const {
  std::uint64_t sum = 0;
  for (const File& file : files_) {
    if (file.samples->source().size() == 0) return 0;
    sum += file.samples->source().size();
  }
  return sum;
}

std::vector<std::string> LogTable::warnings() const {
  std::vector<std::string> all;
  for (const File& file : files_)
    for (std::string& warning : file.samples->warnings()) all.push_back(std::move(warning));
  if (dropped_ > 0)
    all.push_back(file_ + ": " + counted(dropped_, "row") +
                  " dropped at the beginning, before every signal has a value");
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
        all.push_back(file.samples->source().name() + ": " + file.samples->signals()[file.signals[i]].text +
                      " ends " + counted(held, "row") +
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
