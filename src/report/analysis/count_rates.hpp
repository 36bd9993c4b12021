#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/input/spec.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// Largest speed of the coordinate of each encoder, C^-1 q', along the spec's motion, else at the URDF's
/// velocity limits of all joints at once [rad/s or m/s]; empty: not known.
using EncoderSpeeds = std::vector<std::optional<double>>;
EncoderSpeeds encoder_speeds(const Spec&);

/// What an encoder's counter can follow.
struct CountLimit {
  double rate = 0;   ///< [counts/s]
  std::string what;  ///< that limits it, in words
};

/// The lower one of the stated rate and of half a turn of the counter, 2^(bits - 1) counts, in each sample of
/// the slowest filter; empty: none is stated, or no filter takes differences.
std::optional<CountLimit> count_limit(const Spec&, std::size_t encoder);

/// |gear ratio| counts_per_rev speed/(2 pi) [counts/s].
double count_rate(const Spec&, std::size_t encoder, double speed);

/// The largest speed at which the encoder's counter can follow [rad/s or m/s]; empty: no limit is stated.
std::optional<double> largest_speed(const Spec&, std::size_t encoder);

/// A row for each encoder whose count rate is limited: its speed, its rate, their limits; "" if none is.
std::string count_rate_table(const Spec&, const Style&);

/// `120000 counts/s at 3.00 rad/s (the URDF's limit), at most 100000: its max_count_rate`.
/// @pre there is a limit
std::string count_rate_text(const Spec&, std::size_t encoder, double speed);

/// Encoders that cannot count as fast as they turn, and those of which it is not known.
std::vector<std::string> count_rate_warnings(const Spec&);

/// The value of a requirement on a count rate.
/// @throws Error (input) if the speed is not known
double required_count_rate(const Requirement&, const Spec&, const EncoderSpeeds&);

}  // namespace qerr
