#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
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

/// A mapping that a user is asked about, and can paste.
struct MappingProposal {
  LogReading reading;
  std::vector<std::string> left_out;  ///< columns that look like signals, each with what is not known of it
};

/// A mapping of the columns of a log whose names say little: guessed by names (of joints, or their numbers;
/// words for quantities), units and first values. The mapping of the spec and columns that are called as
/// signals are kept.
/// @pre no row of the log has been read
/// @returns no columns if it finds no measured joint
MappingProposal proposed_mapping(const LogTable&, const Spec&);

/// The header of a column that may be the time of a log without one: it rises in equal steps, and its name
/// says nothing else; "" if there is none.
std::string likely_time(const LogTable&, const Spec&);

/// A mapping as options of the command line and, behind them, as a section `log:` of a spec: lines to paste.
std::string mapping_text(const MappingProposal&);

enum class ColumnRole { none, other, position, counts, velocity, effort, command, temperature, tip };

/// A column of the log, as far as it is understood.
struct GuessedColumn {
  std::size_t index = 0;
  std::string name, unit;  ///< of the header
  std::vector<std::string> words;
  std::vector<double> values;
  ColumnRole role = ColumnRole::none;
  std::optional<std::size_t> joint;  ///< of a tip: the coordinate
  int side = 0;                      ///< > 0: of the load; > 1: of a sensor beside the robot
  std::string unknown_unit;          ///< of the header

  bool whole() const;
  double largest() const;
  /// The smallest step between neighbours: that of a quantized column; 0 of one that rests.
  double smallest_step() const;
};

/// Words and numbers of a name, in lower case: `actualQ_0` is actual, q, 0.
std::vector<std::string> words_in(const std::string& name);

/// Whether a word is one of those in a text, which has a blank before and behind each.
bool has_word(std::string_view words, const std::string& word);

/// What a column is by the words of its name, in English, German or French.
ColumnRole role_of(const std::vector<std::string>& words);

/// Whether a word says what a column is, or on which side of the gear it is.
bool is_known_word(const std::string& word);
/// -1 for a word of the motor's side, 1 for one of the load's, 2 for one of a sensor beside the robot.
int side_of(const std::string& word);
/// Whether it is of a sensor beside the robot.
bool is_of_sensor(const std::string& word);

/// The numbers among the first cells of a column, dates and times as seconds.
std::vector<double> numbers_of(const std::vector<std::string>& texts);

/// Correlation coefficient of two columns of one table; 0 if one of them rests, or has gaps.
double correlation_of(const std::vector<double>& x, const std::vector<double>& y);

/// The columns of a log that qerr reads, in the order of the file.
struct LogColumns {
  std::vector<LogColumn> columns;
  std::vector<std::size_t> places;    ///< index of each column in the file
  std::vector<std::string> misspelt;  ///< see Log
};

/// Finds the columns by their names in the header; adds a warning about all other columns.
/// @throws Error (input) like LogReader for headers
LogColumns find_log_columns(const LogTable&, const Spec&, std::vector<std::string>& warnings);

/// A column of a log by its header, with the unit in which it is read.
/// @throws Error (input) for a unit that the signal cannot have
LogColumn column_of(const LogHeader&, LogSignal, std::size_t index, const Chain&);

/// The unit of a column of time stamps, seconds for "".
/// @throws Error (input) if it is no unit of time
Unit time_unit(const std::string& unit, const std::string& header, const Place&);

/// The signals that a log of this robot can have, such as `elbow.counts`.
std::vector<std::string> log_signal_names(const Chain&);

/// @throws Error (input) for a name that is none of them
void require_log_signal(const std::string& name, const Place&, const std::string& path, const Chain&);

}  // namespace qerr
