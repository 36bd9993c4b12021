#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "input/log_samples.hpp"
#include "qerr/input/read_log.hpp"

namespace qerr {

struct TimedValue {
  double time, value;
};

/// How a signal of a file without readings of encoders is joined to the readings of another file.
enum class Joining {
  held,          ///< a reading itself: its last value
  interpolated,  ///< a position: between its samples, and rows beyond them are left out
  extended       ///< a slow one, such as a temperature: interpolated, and held beyond its samples
};

/// The table of a log's signals, one column each: its files joined by time.
///
/// A row for every time stamp of the files with readings of encoders; of their signals the last value is
/// held, the references of other files are interpolated, unless the spec says `missing: hold`. Rows before
/// every chosen signal has had a value are dropped, and so are those that no samples of a reference enclose
/// and, where the spec says so, all in which a signal has no value of its own. Rows of a single wide file are
/// passed on as they are.
class LogTable {
 public:
  /// Reads the headers.
  /// @throws Error like open_log; (input) if there are several files and one has no time stamps
  LogTable(const LogFiles&, const LogReading&, const CsvLimits&);

  /// Name of the file, or of all files.
  const std::string& file() const { return file_; }
  /// The signals of all files, and the time stamps of the first one.
  const std::vector<LogHeader>& header() const { return header_; }

  /// The first values of a column; only before `choose`.
  std::vector<std::string> first_texts(std::size_t column) const {
    const auto& [file, signal] = sources_[column];
    return files_[file].samples->first_texts(signal);
  }

  /// Selects the columns to read, by their index in the header.
  void choose(const std::vector<std::size_t>& columns, const std::vector<Joining>&);

  /// Reads the next row: stores the value of the i-th chosen column in values[i * stride], of time stamps in
  /// seconds after `time_origin`.
  /// @returns false at the end
  bool next(double* values, std::ptrdiff_t stride);

  /// Index of the last row among all rows of the table, dropped ones included, from 0.
  std::uint64_t row() const { return rows_ + dropped_ + unenclosed_ - 1; }
  /// Rows read so far in which a chosen column has no value of its own.
  std::uint64_t held(std::size_t chosen) const {
    return columns_[chosen].time || missing_values_ == MissingValues::drop ? 0
                                                                           : rows_ - columns_[chosen].samples;
  }

  /// Samples of an interpolated column [s after `time_origin`, unit of the file]; null: it is not
  /// interpolated.
  const std::shared_ptr<ColumnSamples>& between(std::size_t chosen) const { return columns_[chosen].between; }

  double time_origin() const { return clock_->origin(); }
  Place last_line() const;
  /// Place and text of a value in the last row.
  Place place(std::size_t chosen) const;
  std::string text(std::size_t chosen) const;
  DecimalText written(std::size_t chosen) const;
  /// Bytes read, and of all files; 0 if one is a pipe.
  std::uint64_t position() const;
  std::uint64_t size() const;

  /// What was noticed while the rows were read; complete at the end.
  std::vector<std::string> warnings() const;

 private:
  struct File {
    std::unique_ptr<LogSamples> samples;
    std::vector<std::size_t> signals, columns;  // chosen: index in the file, and among the chosen columns
    std::vector<double> values;
    double time = 0;
    bool pending = false, ended = false;
    bool interpolated = false;
  };
  struct Column {
    std::size_t file = 0, index = 0;  // among the file's chosen signals
    bool time = false;
    Joining joining = Joining::held;
    double value = std::numeric_limits<double>::quiet_NaN();
    int line = 0;                // of the value
    std::uint64_t last_row = 0;  // with a new value
    std::uint64_t longest_hold = 1;
    std::uint64_t samples = 0;      // in rows that were not dropped
    std::deque<TimedValue> around;  // of an interpolated column: two before the present row, two behind it
    std::shared_ptr<ColumnSamples> between;
  };

  void read_row(File&);
  void take(File&);
  bool interpolate(File&, double time);
  bool is_incomplete() const;
  [[noreturn]] void refuse_incomplete_rows() const;
  std::string incomplete_columns() const;

  MissingValues missing_values_;

  std::unique_ptr<LogClock> clock_ = std::make_unique<LogClock>();
  std::vector<File> files_;
  std::string file_;
  std::vector<LogHeader> header_;
  std::vector<std::pair<std::size_t, std::size_t>> sources_;  // of the header: file, signal
  std::vector<Column> columns_;
  std::size_t missing_ = 0;  // chosen columns without a value so far
  /// Rows; those of them that were left out for a missing value, or stamp; those before every column has a
  /// value.
  std::uint64_t rows_ = 0, left_out_ = 0, unstamped_ = 0, dropped_ = 0;
  bool between_samples_ = false;  ///< a value was interpolated
  std::uint64_t unenclosed_ = 0;  ///< rows that no samples of an interpolated signal enclose
};

}  // namespace qerr
