#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "qerr/core/unit.hpp"
#include "qerr/encoder/transmission.hpp"

namespace qerr {

/// What a column of a log holds.
enum class LogSignal {
  time,         ///< the stamp [s]
  counts,       ///< of the joint's encoder, whole numbers, zero at the joint's zero
  measured,     ///< the joint's position as the robot has it [rad or m]
  reference,    ///< the same by a better sensor [rad or m]
  effort,       ///< [N m or N], or [A], or arbitrary
  velocity,     ///< the controller's own estimate [rad/s or m/s]
  command,      ///< what was asked for, never the truth [rad or m]
  temperature,  ///< [K] from an arbitrary zero: only differences count
  tip           ///< position of the tip by a tracker [m]
};

/// How the numbers of a column are written: what the file itself may have rounded.
///
/// Every value is a multiple of 10^-most_decimals. Numbers printed with `%.4f` have four decimals and many
/// digits, with `%.4g` four digits and many decimals; 15 digits or more are a computer's own number, which
/// the file has not rounded.
struct DecimalText {
  int most_decimals = 0;   ///< digits behind the point, less the exponent
  int least_decimals = 0;  ///< the same, of the row that has the fewest
  int most_digits = 0;     ///< significant ones
};

/// Whole turns that were taken out of a column.
struct Wraps {
  std::int64_t start = 0;       ///< turns added to every row: it began that far from the measured position
  std::uint64_t count = 0;      ///< wraps within the log
  std::uint64_t first_row = 0;  ///< from 0
  double first_time = 0;        ///< [s]
  bool contradicted = false;    ///< later rows span more than a turn: what was taken out were no wraps
};

struct LogColumn {
  LogSignal signal = LogSignal::time;
  std::size_t index = 0;  ///< the independent joint; of the tip 0 x, 1 y, 2 z
  std::string header;     ///< as the file has it
  std::string unit;       ///< of the values: `s`, `rad`, `N m`, `A`, `count`, "1" when arbitrary
  Unit scale;             ///< from the file's unit to that
  DecimalText text;
  Wraps wraps;

  /// The file's own grid: every value (before unwrapping) is a multiple of this [unit].
  double step() const;
};

/// A record of a robot in motion: encoders, better sensors, and what else was written beside them.
///
/// Without a time column it is a static calibration table: its rows have no order.
struct Log {
  std::string file;
  std::vector<LogColumn> columns;
  std::uint64_t rows = 0;
  double first_time = 0, last_time = 0;  ///< [s]
  std::vector<std::string> warnings;
  Eigen::ArrayXXd values;  ///< rows x columns, one column in one piece; empty when rows are streamed
  /// Of a log that is too long to be held: the first rows of the stretches that `values` has, all of
  /// `stretch_rows` but the last. Empty: it has all rows.
  std::vector<std::uint64_t> stretches;
  Eigen::Index stretch_rows = 0;

  /// The column with this signal of this joint (or coordinate of the tip), if there is one.
  std::optional<Eigen::Index> find(LogSignal, std::size_t index = 0) const;

  /// The number in the file of a row of `values`, from 0.
  std::uint64_t row_number(Eigen::Index row) const;

  bool has_time() const { return find(LogSignal::time).has_value(); }
};

/// A joint's position as its robot knows it, over the given rows [rad or m].
///
/// Counts come first, as nothing has rounded them: sum_i C_ji Delta_i counts_i, with the coupling C. Where
/// counts that this needs are missing, the measured column.
/// @param rows  rows x columns of the log
/// @returns empty when the log has neither
std::optional<Eigen::ArrayXd> measured_joint(const Log&, const Eigen::ArrayXXd& rows, const Transmission&,
                                             std::size_t joint);

/// Whether measured_joint has an answer.
bool is_measured(const Log&, const Transmission&, std::size_t joint);

}  // namespace qerr
