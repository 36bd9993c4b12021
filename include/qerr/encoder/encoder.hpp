#pragma once

#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"

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

using EncoderNumbers = std::map<std::string, double>;       ///< checked parameters in SI units, by name
using EncoderChoices = std::map<std::string, std::string>;  ///< checked choices, by name

/// Range within which an encoder's count is absolute: beyond it a recorded count starts again.
enum class AbsoluteRange { none, signal_period, revolution };

/// A row of the list of encoder kinds: one way to state the resolution of an encoder. An encoder of the spec
/// has the key of exactly one kind.
struct EncoderKind {
  std::string_view name;  ///< key that selects the kind
  std::string_view summary;
  std::vector<Parameter> parameters;
  std::string_view example;  ///< of its parameters in a spec
  /// Keys, separated by `|`, that vendors use both for this kind and for another one; refused with the
  /// remedy.
  std::string_view ambiguous_keys = {};
  std::string_view ambiguous_remedy = {};
  /// Counts per revolution of the encoder's shaft, after decoding; null for a kind stated at the joint.
  double (*counts_per_rev)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  /// Quantization interval at the joint [rad or m]; null for a kind stated at the encoder's shaft.
  double (*resolution_at_joint)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  /// Counts in one line or signal period; null: 4, as of a quadrature signal.
  double (*counts_per_period)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  AbsoluteRange absolute_within = AbsoluteRange::none;
  /// How to state the signal period where the kind's own parameters do not determine it; empty where they do.
  std::string_view period_remedy = {};
};

/// All kinds, in the order of `qerr list encoders`.
const std::vector<EncoderKind>& encoder_kinds();

/// @throws std::out_of_range for an unknown name; specs are checked when they are read
const EncoderKind& encoder_kind(std::string_view name);

/// Keys of every kind: gear_ratio, travel_per_rev, rounding, zero, accuracy, limits of the counter.
const std::vector<Parameter>& common_encoder_parameters();

/// Keys of a kind and those of every kind that apply to it: one stated at the joint has no gear.
std::vector<Parameter> encoder_parameters(const EncoderKind&);

}  // namespace qerr
