#pragma once

#include <cmath>

namespace qerr {

/// Rounding of a position to a count.
enum class Rounding {
  nearest,  ///< error in [-Delta/2, Delta/2]
  down      ///< error in (-Delta, 0]: counters that truncate
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
};

/// 1, or -1 where the counter falls while the joint coordinate rises: the sign of the gear ratio.
inline double direction(const Encoder& e) { return e.shaft_ratio < 0 ? -1 : 1; }

/// Mean of the quantization error, estimate - true [rad or m]: 0, or -Delta/2 for `down`.
inline double mean_error(const Encoder& e) {
  return e.rounding == Rounding::down ? -0.5 * e.resolution : 0.0;
}

/// Standard deviation of the pseudo-quantization noise, Delta/sqrt(12) (paper, Eq. 6) [rad or m].
inline double sigma(const Encoder& e) { return e.resolution / std::sqrt(12.0); }

/// The quantized position (paper, Eq. 1 with the sign of Eq. 10) [rad or m].
inline double quantize(const Encoder& e, double position) {
  const double counts = position / e.resolution;
  return e.resolution * (e.rounding == Rounding::down ? std::floor(counts) : std::floor(counts + 0.5));
}

}  // namespace qerr
