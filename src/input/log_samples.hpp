#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "input/csv.hpp"
#include "input/log_clock.hpp"
#include "input/log_names.hpp"
#include "qerr/input/read_log.hpp"

namespace qerr {

/// A signal of a log's file: a column of a wide file, or a name in the column `signal` of a long one.
struct LogHeader {
  std::string text;  ///< `NAME [UNIT]`
  Place place;
  ColumnMeaning meaning;
};

/// One file of a log as samples in the order of time.
///
/// Wide: a column a signal. Long (a header with `time`, `signal`, `value` and perhaps `unit`): a row a
/// sample; it is kept in memory, 24 bytes a sample, as its signals may follow one after the other.
class LogSamples {
 public:
  explicit LogSamples(std::string file) : file_(std::move(file)) {}
  virtual ~LogSamples() = default;

  /// All signals, the time stamps of a wide file included.
  const std::vector<LogHeader>& signals() const { return signals_; }
  /// Index of the time stamps among the signals; empty if the file has none.
  std::optional<std::size_t> time() const { return time_; }

  /// Selects the signals to read, in the order in which `next` stores them; the time stamps are not among
  /// them.
  /// @throws Error (input) for a sample of these signals that is no number or runs backwards in time, at the
  /// latest from `next`
  virtual void choose(const std::vector<std::size_t>& signals) = 0;

  /// The next samples, all of one time stamp: their values, NaN for a signal that has none.
  /// @param time  [s] after the clock's origin; 0 if the file has no stamps
  /// @returns false at the end
  virtual bool next(double& time, double* values) = 0;

  /// Line read last; line, place and text of a signal's last sample, and the decimals of all its samples so
  /// far.
  virtual int line() const = 0;
  virtual int line_of(std::size_t) const { return line(); }
  virtual Place place(std::size_t chosen) const = 0;
  virtual std::string text(std::size_t chosen) const = 0;
  virtual DecimalText written(std::size_t chosen) const = 0;
  virtual DecimalText written_time() const = 0;

  /// The first values of a signal as texts; only before `choose`.
  virtual std::vector<std::string> first_texts(std::size_t signal) const = 0;

  const std::string& file() const { return file_; }
  /// The name of the file, and of the topic of a bag.
  virtual std::string name() const { return file_; }
  /// Bytes of the file, 0 of a pipe or of arrays; those of them that have been read.
  virtual std::uint64_t size() const { return 0; }
  virtual std::uint64_t position() const { return 0; }
  /// What a user should know about the file; complete after `choose`.
  virtual std::vector<std::string> warnings() const = 0;

 protected:
  std::string file_;
  std::vector<LogHeader> signals_;
  std::optional<std::size_t> time_;
  std::vector<std::size_t> chosen_;
};

/// Opens a file and reads its header, of a long file everything; of a bag each topic is a file of its own.
/// @param reading  the mapping of columns; where an empty cell leaves out its row, a row without a time stamp
/// has the time NaN, else it is an error
/// @param clock  of all files of the log; must outlive the result
/// @throws Error like CsvReader; (input) for a long file without time stamps, or a signal with two units, a
/// bag that is damaged, or has nothing to read
std::vector<std::unique_ptr<LogSamples>> open_log(const std::string& path, const CsvLimits&,
                                                  const LogReading& reading, LogClock& clock);

/// For a bag (see BagFile): a first pass finds its signals, and each stream of samples is read again.
std::vector<std::unique_ptr<LogSamples>> open_bag_log(const std::string& path, const LogReading&, LogClock&);

/// Opens arrays in memory as a log. They must outlive the result.
/// @throws Error (input) if they do not have equally many values
std::unique_ptr<LogSamples> array_samples(const std::vector<LogArray>&, const CsvLimits&, const LogReading&,
                                          LogClock&);

/// For a long file, whose header has the columns `signal` and `value`.
std::unique_ptr<LogSamples> read_long_log(std::unique_ptr<CsvReader>, const LogReading&, LogClock&);

inline constexpr std::size_t sampled_stamps = 20;  // say their unit

/// The first cells of a column.
using ColumnTexts = std::function<std::vector<std::string>(std::size_t column)>;

/// The column of the time stamps: by its name, if the name may mean something else by its values, too; else
/// the only one of dates, times of day, or in a unit of time. Empty if there is none, or several may be it.
/// @param header  of the file
std::optional<std::size_t> find_stamps(const std::vector<std::string>& header,
                                       const std::vector<ColumnMeaning>&, const ColumnTexts&);

/// The column of nanoseconds behind one of whole seconds: `header.stamp.sec` and `header.stamp.nanosec`; in a
/// table without header behind seconds since 1970, where what stands behind them does not fall within a
/// second and starts again with the next. (Counts behind whole seconds are none.)
std::optional<std::size_t> nanoseconds_behind(const std::vector<std::string>& header, std::size_t seconds,
                                              const ColumnTexts&);

/// What the first of a file's time stamps say: completes the unit of their column, where neither header nor
/// mapping gives it.
/// @returns what was recognized, for a warning; "" if nothing was
std::string recognize_stamps(const std::string& file, const std::vector<std::string>& header,
                             std::size_t column, std::vector<std::string> first_texts, ColumnMeaning&);

/// The first cells of a column; only before the first row is read.
std::vector<std::string> first_cells(const CsvReader&, std::size_t column, std::size_t most);

/// The format of a table that is no plain one, and what was recognized of its time stamps.
std::vector<std::string> format_warnings(const CsvReader&, const std::string& stamps);

/// The unit of stamps that are whole numbers and follow each other at a rate of a robot's log, 5 Hz to 20
/// kHz, in no other unit; "" if there is none, or several.
std::string unit_of_steps(const std::vector<double>& stamps);

class StampReader {
 public:
  /// @param column  of the time stamps; the i-th of the texts that the table reads
  /// @param unit  "" for seconds
  /// @param nanoseconds  whether the text behind it has those of the stamp, which are whole seconds
  StampReader(const CsvReader& table, std::size_t column, std::size_t text, const std::string& unit,
              LogClock& clock, bool nanoseconds = false);

  /// The stamp of the last row [s]. @throws Error (input) if it is none
  double operator()();
  bool is_empty() const { return table_.chosen_text(text_).empty(); }
  /// @throws Error (input) that time must not decrease
  [[noreturn]] void refuse_before(double last) const;
  DecimalText written() const { return written_.text(); }

 private:
  [[noreturn]] void refuse(const std::string& rule, const std::string& remedy) const;

  const CsvReader& table_;
  std::size_t column_, text_;
  bool nanoseconds_;
  LogClock& clock_;
  Unit unit_;
  WrittenNumbers written_;
};

}  // namespace qerr
