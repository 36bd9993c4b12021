#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qerr/input/spec.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// A column of a log in memory that the caller keeps: NaN is a missing value.
struct LogArray {
  std::string name;  ///< like the header of a file
  const double* values = nullptr;
  std::size_t rows = 0;
  std::ptrdiff_t stride = 1;

  double at(std::size_t row) const { return values[static_cast<std::ptrdiff_t>(row) * stride]; }
};

/// The files of a log, which are joined by time: a row for every time stamp of the files with readings of
/// encoders, whose last values are held; references of other files are interpolated by the cubic through four
/// samples, and what they do not enclose is left out, with a warning. Where the spec says `missing: hold`, a
/// row for every stamp of any file and the last value of each signal. Rows before every signal has had a
/// value are dropped, with a warning. Of an empty cell of a wide file, or one that says `nan`, the spec says
/// what becomes (`LogReading`): the row is left out (of joined files every row in which a signal has no value
/// of its own), or the last value of its column is held, both with a warning; else it is an error.
///
/// Tables may be separated by commas, semicolons, tabulators or blanks, with decimal commas, preambles and in
/// other encodings than UTF-8; what was recognized is among the log's warnings. Columns of other names than
/// signals' are read by the spec's mapping; without one the error proposes it. A bag of ROS 2 (`.mcap`,
/// `.db3`, the folder of a recording) is as many files as it has topics; it is read twice, as a stream.
///
/// A file is wide, a column each signal, or long: `time [s],signal,value` and perhaps `unit`, a row each
/// sample. Of a long file every signal must be in the order of time, not the file. It is kept in memory, 24
/// bytes a sample.
struct LogFiles {
  LogFiles(const std::string& path) : paths{path} {}
  LogFiles(std::vector<std::string> all) : paths(std::move(all)) {}
  LogFiles(std::vector<LogArray> columns) : arrays(std::move(columns)) {}

  std::vector<std::string> paths;
  std::vector<LogArray> arrays;  ///< one more file, without a copy of its values
};

struct LogOptions {
  std::size_t block_bytes = 1 << 18;  ///< bytes of the file per read
  std::size_t longest_row = 1 << 20;  ///< [bytes]
  Eigen::Index block_rows = 4096;     ///< rows per call of `next`
  /// Called with the bytes that are read and those of the file; not for a pipe.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
};

/// Reads a measured log in blocks, in memory that does not grow with a wide file.
///
///     LogReader reader("log.csv", spec);
///     Eigen::ArrayXXd rows;
///     while (reader.next(rows)) use(reader.log(), rows);
///
/// Columns are found by their header, `NAME [unit]`, and converted to SI units: `time`; `JOINT.counts`,
/// `JOINT.measured`, `JOINT.reference`, `JOINT.effort`, `JOINT.velocity`, `JOINT.command`,
/// `JOINT.temperature` of the spec's independent joints; `tip.x`, `tip.y`, `tip.z`. Others are ignored with
/// one warning.
///
/// `reference`, `measured` and `command` of revolute joints, and `counts` of encoders that are absolute
/// within a revolution, are unwrapped (`Unwrap`). Jumps of an incremental counter are kept: they are faults
/// to be diagnosed. If a reference or command starts a whole number of turns (within a quarter turn) away
/// from the measured position, these turns are removed from all its rows; from the measured position if it
/// alone wraps, or starts again within a turn of the joint. In a table without time, whose rows have no
/// order, and where the joint leaps from one row to the next, turns are those of the difference of reference
/// and measured position (`turns_by_difference`).
class LogReader {
 public:
  /// Reads the headers. `-` is standard input.
  /// @throws Error (file_system) if a file cannot be read; (input), with line and column, for a file without
  /// time stamps among several, a column that is duplicate (in one file or two), has a wrong unit or is
  /// missing: the measured signal of a joint with a reference, of every joint if the tip is tracked, of all
  /// joints
  LogReader(const LogFiles&, const Spec&, const LogOptions& = {});
  ~LogReader();
  LogReader(LogReader&&) noexcept;
  LogReader& operator=(LogReader&&) noexcept;

  /// The columns and, of the rows read so far, their number, times, decimals and unwrapped turns.
  const Log& log() const;

  /// The next rows, rows x log().columns. @returns false at the end
  /// @throws Error (input), with line and column, for a row with too few or too many cells, a cell that is
  /// not a finite number, counts beyond 2^53, or off every grid of 1/1024 count or
  /// coarser, or not whole although a coupling joins them, decreasing time, a file without rows
  bool next(Eigen::ArrayXXd& rows);

  /// Index in the file of each row that `next` has read last, from 0; empty: rows follow one another from the
  /// first of the file on.
  const std::vector<std::uint64_t>& file_rows() const;

 private:
  class Rows;
  std::unique_ptr<Rows> rows_;
};

/// Values of a log that read_log keeps, unless it is told otherwise.
inline constexpr std::uint64_t most_log_values = 32'000'000;

/// A log with its values. Counts with a `denominator` above 1 become the signal `measured`, with a warning.
/// Of a log with more than `most_values` values, evenly spaced stretches of 16384 rows with at least half as
/// many values are kept, with a warning. Memory is at most 8 bytes per value, for any length of a wide file.
/// @param progress  as of LogOptions
Log read_log(const LogFiles&, const Spec&, std::uint64_t most_values = most_log_values,
             std::function<void(std::uint64_t done, std::uint64_t total)> progress = {});

}  // namespace qerr
