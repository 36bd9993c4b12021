#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "qerr/core/quantity.hpp"
#include "qerr/encoder/transmission.hpp"

namespace qerr {

/// The quantity of a column of a log.
enum class LogSignal {
  time,         ///< time stamp [s]
  counts,       ///< of the encoder, integers, zero at the zero of the joint; rising with the joint once read
  measured,     ///< joint position as the controller reads it [rad or m]
  reference,    ///< joint position by the reference sensor [rad or m]
  effort,       ///< [N m or N], [A] or an arbitrary unit
  velocity,     ///< estimate of the controller [rad/s or m/s]
  command,      ///< commanded position, which is not the true one [rad or m]
  temperature,  ///< from an arbitrary zero: only differences are used [K]
  tip           ///< position of the tip, measured by a tracker [m]
};

/// Decimals and digits of the numbers in a column, which determine the rounding by the file.
///
/// Every value is a multiple of 10^-most_decimals. Numbers printed with `%.4f` have four decimals and any
/// number of digits, with `%.4g` four digits and any number of decimals; 15 digits or more are an unrounded
/// double.
struct DecimalText {
  int most_decimals = 0;   ///< digits after the decimal point, minus the exponent
  int least_decimals = 0;  ///< the same of the row with the fewest
  int most_digits = 0;     ///< significant digits
};

/// Whole turns that were removed from a column by unwrapping.
struct Wraps {
  std::int64_t start = 0;       ///< turns added to every row: initial difference from the measured position
  std::uint64_t count = 0;      ///< wraps within the log
  std::uint64_t first_row = 0;  ///< from 0
  double first_time = 0;        ///< as recorded [s]
  bool contradicted = false;    ///< later rows span more than a turn: the removed steps were not wraps
};

/// Between which the values of a column are interpolated.
struct ColumnSamples {
  std::vector<double> time;   ///< ascending, in the time of the log [s]
  std::vector<double> value;  ///< with the turns of the file [unit of the column]
};

struct LogColumn {
  LogSignal signal = LogSignal::time;
  std::size_t index = 0;  ///< independent joint, or coordinate of the tip: 0 x, 1 y, 2 z
  std::string header;     ///< text in the file
  std::string unit;       ///< of the values: `s`, `rad`, `N m`, `A`, `count`, "1" if arbitrary
  Unit scale;             ///< from the unit of the file to `unit`
  DecimalText text;
  Wraps wraps;
  /// Of counts: they are multiples of 1/denominator; above 1 for an interpolated encoder; known at the end.
  int denominator = 1;
  bool computed = false;   ///< of an effort: the load by the masses of the URDF, and not what a drive needs
  std::uint64_t held = 0;  ///< rows that had no value of their own and have the last one
  std::shared_ptr<const ColumnSamples> samples;  ///< null: the rows have values of their own

  /// Log resolution: every value (before unwrapping) is a multiple of this [unit].
  double step() const;
};

/// A record of a robot in motion: encoders, reference sensors and other measured quantities.
///
/// Without a time column it is a static calibration table, whose rows have no order.
struct Log {
  std::string file;
  std::vector<LogColumn> columns;
  std::uint64_t rows = 0;
  double first_time = 0, last_time = 0;  ///< as recorded [s]
  /// Recorded time of the zero of the column `time` [s]: 0, or the first stamp of a log that counts from an
  /// epoch, where a double would not resolve 1 ns (beyond 2^23 s).
  double time_origin = 0;
  std::vector<std::string> warnings;
  Eigen::ArrayXXd values;  ///< rows x columns, column-major; empty if rows are streamed
  /// First rows of the stretches in `values` if the log is too long to be kept; all stretches but the last
  /// have `stretch_rows` rows. Empty: `values` has all rows.
  std::vector<std::uint64_t> stretches;
  Eigen::Index stretch_rows = 0;
  /// Index in the file of each row of `values`, from 0, where others have been left out; empty: see
  /// `stretches`.
  std::vector<std::uint64_t> file_rows;
  /// Joints (or coordinates of the tip: `tip.x`) of which a position is missing and an ignored column is
  /// called nearly so, such as `elbow.refrence`.
  std::vector<std::string> misspelt;

  /// Index of the column with this signal of this joint (or coordinate of the tip); empty if absent.
  std::optional<Eigen::Index> find(LogSignal, std::size_t index = 0) const;

  /// Index in the file of a row of `values`, from 0.
  std::uint64_t row_number(Eigen::Index row) const;

  /// The rows next in time to the samples of an interpolated column, ascending: between samples its values
  /// err alike from row to row. Empty: all rows.
  std::vector<Eigen::Index> rows_at_samples(std::size_t column) const;

  bool has_time() const { return find(LogSignal::time).has_value(); }
};

/// The measured position of a joint over the given rows [rad or m].
///
/// sum_i C_ji Delta_i counts_i with the coupling C if the log has the counts of all these encoders, since
/// counts are not rounded by the file; else the column `measured`.
/// @param rows  rows x columns of the log
/// @returns empty if the log has neither
std::optional<Eigen::ArrayXd> measured_joint(const Log&, const Eigen::ArrayXXd& rows, const Transmission&,
                                             std::size_t joint);

/// Whether the log has the columns that `measured_joint` needs.
bool is_measured(const Log&, const Transmission&, std::size_t joint);

}  // namespace qerr
