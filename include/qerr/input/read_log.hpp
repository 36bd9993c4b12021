#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "qerr/input/spec.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

struct LogOptions {
  std::size_t block_bytes = 1 << 18;  ///< of the file that are read at once
  std::size_t longest_row = 1 << 20;  ///< [bytes]
  Eigen::Index block_rows = 4096;     ///< of values that `next` gives at once
};

/// Reads a measured log (CSV) in blocks, in memory that does not grow with the file.
///
///     LogReader reader("log.csv", spec);
///     Eigen::ArrayXXd rows;
///     while (reader.next(rows)) use(reader.log(), rows);
///
/// Columns are found by their header, `NAME [unit]`, and come in SI units: `time`; `JOINT.counts`,
/// `JOINT.measured`, `JOINT.reference`, `JOINT.effort`, `JOINT.velocity`, `JOINT.command`,
/// `JOINT.temperature` of the spec's independent joints; `tip.x`, `tip.y`, `tip.z`. Others are ignored with
/// one warning.
///
/// Whole turns are taken out (`Unwrap`) of `reference`, `measured` and `command` of joints that turn, and of
/// `counts` of an absolute encoder: one given by bits, or with one signal period a revolution. An incremental
/// counter that jumps is left as it is, as that is a fault to be found. Where a reference or command begins a
/// whole number of turns (less than a quarter of one more or less) from the measured position, these are
/// taken out of all its rows. In a table without time, whose rows have no order, the reference follows the
/// measured position instead: where their difference has a step of about a turn.
class LogReader {
 public:
  /// Reads the header. `-` is standard input.
  /// @throws Error (file_system) when the file cannot be read; (input), with line and column, for a column
  /// that is there twice, has a wrong unit or is missing: the measured signal of a joint that has a
  /// reference, of every joint where the tip is tracked, of all joints
  LogReader(const std::string& path, const Spec&, const LogOptions& = {});
  ~LogReader();
  LogReader(LogReader&&) noexcept;
  LogReader& operator=(LogReader&&) noexcept;

  /// What the header says, and, as far as rows have been read, how many there are, their times, how their
  /// numbers are written and which columns have been unwrapped.
  const Log& log() const;

  /// The next rows, rows x log().columns. @returns false when there are no more
  /// @throws Error (input), with line and column, for a ragged row, a cell that is empty or no finite number,
  /// counts that are no whole number within 2^53, time that runs backwards, a file without rows
  bool next(Eigen::ArrayXXd& rows);

 private:
  class Rows;
  std::unique_ptr<Rows> rows_;
};

/// A log, its values included: all rows, or of one with more than `most_values` evenly spread stretches of
/// 16384 rows that together have at least half as many (a warning says so). Memory stays within 8 bytes a
/// value, whatever the file's length.
Log read_log(const std::string& path, const Spec&, std::uint64_t most_values = 32'000'000);

}  // namespace qerr
