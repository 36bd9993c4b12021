#pragma once

#include <cmath>

namespace qerr {

/// Rounding of a position to a count.
enum class Rounding {
  nearest,  ///< error in [-Delta/2, Delta/2]
  down      ///< of the counter: its error is in (-1, 0] counts
};

/// An ideal encoder, in joint coordinates (after its gear).
struct Encoder {
  double resolution = 0;  ///< quantization interval Delta [rad, or m for a prismatic joint], > 0
  Rounding rounding = Rounding::nearest;
  bool zero_known = true;  ///< false: incremental without index, a constant error is not identifiable
  double shaft_ratio = 1;  ///< angle of the encoder shaft per joint coordinate, signed [rad/rad or rad/m]
  double counts_per_period = 4;  ///< counts in one line or signal period
  /// Bound on the slow error of disc or scale, of unknown shape, in joint coordinates [rad or m]; 0: not
  /// stated.
  double accuracy = 0;
  /// Bound on the slow error of the gear between shaft and joint [rad or m at the joint]; 0: not stated.
  double gear_accuracy = 0;
};

/// 1, or -1 where the counter falls while the joint coordinate rises: the sign of the gear ratio.
inline double direction(const Encoder& e) { return e.shaft_ratio < 0 ? -1 : 1; }

/// How far a position may lie below its reading, in intervals: 1/2. A counter that rounds down shows no more
/// than the position: 0, or 1 where it falls while the joint coordinate rises.
inline double below_reading(const Encoder& e) {
  if (e.rounding == Rounding::nearest) return 0.5;
  return direction(e) < 0 ? 1 : 0;
}

/// Mean of the quantization error, estimate - true [rad or m]: 0; of a counter that rounds down -Delta/2, or
/// Delta/2 with a negative gear ratio.
inline double mean_error(const Encoder& e) { return (below_reading(e) - 0.5) * e.resolution; }

/// Standard deviation of the pseudo-quantization noise, Delta/sqrt(12) (paper, Eq. 6) [rad or m].
inline double sigma(const Encoder& e) { return e.resolution / std::sqrt(12.0); }

/// The quantized position (paper, Eq. 1 with the sign of Eq. 10) [rad or m].
inline double quantize(const Encoder& e, double position) {
  const double counts = position / e.resolution;
  const double below = below_reading(e);
  return e.resolution * (below == 1 ? std::ceil(counts) : std::floor(counts + below));
}

}  // namespace qerr
