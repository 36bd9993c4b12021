#pragma once

#include <optional>
#include <string_view>

#include "core/statistics.hpp"
#include "diagnose/record/sanity/sanity.hpp"

/// The steps of check_sanity, in their order. Each step reads the log as the previous steps have repaired it.
namespace qerr::sanity {

/// Rows from which a slope says something (convention).
inline constexpr Eigen::Index fewest_rows_of_slope = 16;

/// Motion of which a sensor must show something [counts] (convention).
inline constexpr double missed_motion = 20;

/// The counts of one encoder.
struct RecordedCounts {
  Eigen::Index column = 0;  ///< of the log
  bool direct = true;       ///< recorded as counts; else computed as measured position / resolution
  Eigen::ArrayXd counts;
};

/// Empty if the log has neither counts nor, for an uncoupled joint, the measured position.
std::optional<RecordedCounts> recorded_counts(const Sanity&, std::size_t encoder);
bool has_counts(const Sanity&, std::size_t encoder);

/// Writes counts of the model's present resolution to the log.
void write_back(Sanity&, const RecordedCounts&, std::size_t encoder);

/// Reference in the encoder's coordinate, from the references of all joints that move it [rad or m]; empty if
/// one of them is missing.
Eigen::ArrayXd encoder_reference(const Sanity&, std::size_t encoder);
Eigen::ArrayXd reference_in_counts(const Sanity&, std::size_t encoder);
bool has_reference(const Sanity&, std::size_t encoder);

/// Evenly spaced rows of a long column, enough for a slope or a standard deviation; all of a short one.
Eigen::ArrayXd some_rows(const Eigen::Ref<const Eigen::ArrayXd>&);

/// Standard deviation of a joint's quantization error, from all encoders that determine it [rad or m].
double ideal_sigma(const Sanity&, std::size_t joint);

/// A cause at the encoder's joint whose numbers are exact, with its gain over all rows.
Cause exact_cause(const Sanity&, std::size_t encoder, std::string_view effect,
                  std::map<std::string, double> numbers, double p_value, double rms_before, double rms_after);

/// The remaining effect of this type that the spec has at the encoder's joint; null if the spec has no such
/// effect.
const Effect* specified_effect(const Sanity&, std::size_t encoder, std::string_view effect);

/// Removes an effect of the spec that has been undone in the log.
void remove_effect(Sanity&, const Effect*);

/// Converts counts that are `factor` times the true ones to true counts, with the model's edges where those
/// of the readings lie.
///
/// Which of the true edges a coarser counter uses is not recorded. If the encoder's zero is known, the edge
/// is chosen that agrees with the reference, within one reading.
/// @returns rms of measured - reference after the conversion, 0 without a reference
double decode(Sanity&, RecordedCounts, std::size_t encoder, double factor);

/// From here on the readings are judged in steps of several counts, as are the losses that the spec states.
void judge_in_steps(Sanity&, RecordedCounts&, std::size_t encoder, double counts);

/// Removes a column from the log.
void drop_column(Log&, Eigen::Index column);

/// Removes all other rows from the log.
/// @param rows  ascending
void keep_rows(Sanity&, const std::vector<Eigen::Index>& rows);

/// Time stamp of a row; empty: the log has none.
std::optional<double> time_of(const Sanity&, Eigen::Index row);

/// A unit that fits the values of a column, and by how much they are larger in it.
struct OtherUnit {
  std::string_view name;
  double factor = 1;
};

/// The unit of a column whose values are `ratio` times the true ones, if it is another than the header's.
std::optional<OtherUnit> other_unit(const LogColumn&, double ratio, bool prismatic);

void check_stamps(Sanity&);
void check_motion(Sanity&, std::size_t encoder);
void check_exchange(Sanity&);
void check_unit(Sanity&, std::size_t joint);
void check_outliers(Sanity&);
void check_held_cells(Sanity&);
void check_held_sensors(Sanity&);
/// Makes the values of columns in all rows but some the samples of these columns.
/// @param rows  that are left out, ascending
void leave_out(Log&, const std::vector<Eigen::Index>& columns, const std::vector<Eigen::Index>& rows);
/// A tracker's repeated values: its fresh ones become the samples of its columns.
void check_held_tip(Sanity&);
/// The finding of a tracker's positions that no motion has.
/// @param rows     of the file, from 1
/// @param largest  distance [m]
DataFinding far_positions(const std::vector<std::uint64_t>& rows, double largest, std::optional<double> time);
/// A tracker's single positions that are far off: the others become the samples of its columns.
void check_tip_outliers(Sanity&);
void check_interpolated(Sanity&);
void check_unrelated(Sanity&, std::size_t encoder);
void check_reference_grid(Sanity&, std::size_t encoder);
void check_reference_noise(Sanity&, std::size_t encoder);
void check_constant_columns(Sanity&, std::size_t encoder);
/// Whether positions were chosen in the steps that their values have. Then these look as with a fault, such
/// as rounding or a stuck bit, but lack its error: with the fault the variance is that of the quantization
/// and `of_fault`, and here it is below that of the quantization and a quarter of it, half of the deviation.
/// In a table without time, errors that follow the position do not count.
/// @param values    that have the steps: counts, or reference
/// @param of_fault  [counts^2]
/// @returns false without a reference
bool are_chosen_in_steps(const Sanity&, std::size_t encoder, const Eigen::ArrayXd& values, double of_fault);

/// Turns that were taken for wraps, until the counts went beyond one turn, are put back by the reference.
void check_turns(Sanity&, std::size_t encoder);
void check_rollover(Sanity&, std::size_t encoder);
void check_decoding(Sanity&, std::size_t encoder);
void check_losses(Sanity&, std::size_t encoder);
void check_log_resolution(Sanity&, std::size_t encoder);
void check_frozen_reference(Sanity&, std::size_t encoder);
void check_stuck_sensor(Sanity&, std::size_t encoder);
void check_controller_output(Sanity&, std::size_t encoder);
void check_loads(Sanity&);
/// Turns the sign of a joint's effort. @pre the log has it
DataFinding reverse_effort(Sanity&, std::size_t joint);
/// A bit of the counts that never changes: it is taken from the reference.
void check_stuck_bit(Sanity&, std::size_t encoder);

/// A bit of counts that never changes, and its value where the counts are those of the counter.
struct StuckBit {
  int bit = 0;
  std::optional<bool> value;
};

/// The lowest bit above the last one that is equal in all counts, and whose restoration makes them follow the
/// reference: some passages between two of its halves are enough.
std::optional<StuckBit> stuck_bit_by_reference(const Sanity&, std::size_t encoder);

/// The lowest bit for which one half of the remainders by 2^(bit + 1), in a row, does not occur, and the
/// counts leap over it: a steady motion by so many counts a row misses remainders, too.
std::optional<StuckBit> stuck_bit(const Eigen::ArrayXd& counts);

void check_tracker(Sanity&);
void check_unreferenced(Sanity&, std::size_t encoder);
void check_velocity_column(Sanity&, std::size_t joint);
void check_velocity(Sanity&, const std::vector<Filter>&, std::size_t encoder);

}  // namespace qerr::sanity
