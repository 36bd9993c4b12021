#pragma once

#include <optional>

#include "core/statistics.hpp"
#include "diagnose/record/sanity.hpp"

/// The steps of check_sanity, in their order. Each reads the log as the steps before have left it.
namespace qerr::sanity {

/// What one encoder read.
struct Readings {
  Eigen::Index column = 0;  ///< of the log
  bool whole = true;        ///< from a column of counts; else a measured position over the resolution
  Eigen::ArrayXd counts;
};

/// Empty where the log has neither counts nor, of an uncoupled joint, the measured position.
std::optional<Readings> readings(const Sanity&, std::size_t encoder);

/// Writes readings back, in counts of the model's present resolution.
void write_back(Sanity&, const Readings&, std::size_t encoder);

/// The encoder's coordinate by the references of all joints that it feels [rad or m]; empty where one is
/// missing.
Eigen::ArrayXd encoder_reference(const Sanity&, std::size_t encoder);

/// Standard deviation of a joint's own quantization error, by all encoders that it is made of [rad or m].
double ideal_sigma(const Sanity&, std::size_t joint);

/// A cause of the encoder's joint whose numbers are exact; the gain is of all rows.
Cause cause(const Sanity&, std::size_t encoder, const char* effect, std::map<std::string, double> numbers,
            double p_value, double rms_before, double rms_after);

/// The spec's effect of this type on the encoder's joint, null where it has none left.
const Effect* known(const Sanity&, std::size_t encoder, std::string_view effect);

/// An effect of the spec that has been undone in the log.
void forget(Sanity&, const Effect*);

/// Readings that are `factor` times the counts, brought to these; the encoder's edges lie where the readings
/// have theirs.
///
/// Which of its edges a coarser counter uses, nobody knows: if the encoder's zero is known, the one that the
/// reference tells, within one reading.
/// @returns rms of measured - reference then, 0 without a reference
double decode(Sanity&, Readings, std::size_t encoder, double factor);

/// Takes a column out of the log.
void drop_column(Log&, Eigen::Index column);

void check_stamps(Sanity&);
void check_dead(Sanity&, std::size_t encoder);  ///< columns that never move
void check_rollover(Sanity&, std::size_t encoder);
void check_decoding(Sanity&, std::size_t encoder);
void check_grids(Sanity&, std::size_t encoder);
void check_stuck(Sanity&, std::size_t encoder);  ///< a sensor that stood still for a while
void check_droop(Sanity&, std::size_t encoder);
void check_velocity(Sanity&, const std::vector<Filter>&, std::size_t encoder);

}  // namespace qerr::sanity
