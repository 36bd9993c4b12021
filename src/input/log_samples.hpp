#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/csv.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A time stamp, exact to 1e-18 s; both parts have one sign.
struct TimeStamp {
  std::int64_t seconds = 0, attoseconds = 0;
};

/// The unit of a stamp without one that counts from 1970, by its size: `ms`, `us` or `ns`, or `100 ns` from
/// 1601 or the year 1; "" for a smaller one, in seconds.
std::string epoch_unit(double stamp);

/// A date as days since 1970. In `11/05/2026` day and month may be exchanged, then the other reading, too.
struct CalendarDate {
  std::int64_t days = 0;
  std::optional<std::int64_t> exchanged;
  bool month_first = false;  ///< as the numbers say: `11/26/2026`
};

/// A date with the number of its month in place of the name: `14-Mar-2026` is `14-3-2026`; other texts are
/// returned as they are.
std::string with_month_number(std::string_view text);

/// The time stamps of a log, in seconds after one origin.
///
/// A double resolves 1 ns up to 2^23 s (97 days). A log whose first stamp lies beyond counts from an epoch:
/// this stamp becomes the origin, and it is subtracted before a stamp is rounded to double.
class LogClock {
 public:
  /// @param text  a decimal number in `unit` or, for a unit of 1 s, `2026-05-01T12:00:00.5Z` (ISO 8601),
  /// `26.11.2026 17:16:42,123`, `14-Mar-2026 17:16:42`, or a time of day, of the next day (`mm:ss.5` of the
  /// next hour) where it falls by more than half of one; a counter of 32 bits may roll over. With slashes the
  /// day is first, unless a stamp says or the next date shows that the month is; memory as of
  /// CsvReader::chosen_text
  /// @returns empty if it is none, or out of the range of double
  std::optional<double> seconds(std::string_view text, const Unit&, WrittenNumbers&);

  double seconds(const TimeStamp&);
  double seconds(double stamp);  ///< [s]

  /// What the stamps are taken for that are no plain time: "" or "they run over midnight".
  const std::string& remark() const { return remark_; }
  /// Recorded time of the origin [s].
  double origin() const;

 private:
  double unwrapped(double number, const Unit&);
  std::int64_t days(const CalendarDate&);

  std::optional<TimeStamp> origin_;
  std::optional<CalendarDate> last_date_;
  bool month_first_ = false;
  std::int64_t shift_ = 0;  ///< days by which dates before `month_first_` was known were read too late

  std::optional<std::int64_t> last_time_of_day_;  ///< [s], over all days
  double last_number_ = 0, rollovers_ = 0;        ///< of a counter of 32 bits
  std::string remark_;
};

/// The unit that a word of a log's header means, as qerr writes it: `degrees`, `°`, `Grad` are `deg`, `msec`
/// is `ms`, `ticks` are `count`; "" if it is none.
std::string unit_in_words(std::string_view word);

/// The parts of a log's header cell, whose unit may be in brackets, in parentheses, behind a slash, a comma,
/// a word or an underscore, and in other words: `angle (degrees)`, `Zeit / s`, `t_ms`, `Winkel in Grad`.
ColumnName measured_name(const std::string& cell);

/// Whether a name, without its unit, means the time stamps: `Time`, `timestamp`, `Zeit`, `__time`.
bool is_time_name(std::string_view name);

/// What a column of a log's file is by its name, or by the mapping of columns.
struct ColumnMeaning {
  std::string signal;   ///< `time`, `a1.counts`; of an unknown column its name
  std::string unit;     ///< "" without one
  bool mapped = false;  ///< by the mapping
};

std::vector<ColumnMeaning> column_meanings(const std::vector<std::string>& header, const LogReading&);

/// Index of the time stamps: the column that the mapping names, else `time`, else the only one with a name
/// like it; empty if there is none.
std::optional<std::size_t> time_column(const std::vector<ColumnMeaning>&);

/// The unit of stamps that a program writes without it, told by its other columns: logs of libfranka are in
/// ms;
/// "" for others.
std::string program_time_unit(const std::vector<std::string>& header);

/// Adds `SIGNAL=COLUMN` or `SIGNAL=COLUMN [UNIT]`, as of --column, to the mapping of a spec, in place of what
/// it has for this signal.
/// @throws Error (usage) for another text, or a signal that no log of this robot has
void map_column(const std::string& assignment, Spec&);

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
