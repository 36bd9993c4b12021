#pragma once

#include <cstddef>
#include <cstdint>

#include "lanes/select_kernels.hpp"

// Included by kernel sources, which are compiled per instruction set: therefore without Eigen and containers,
// whose inline functions the linker would merge with those of other translation units.

namespace qerr {

/// Below this cosine of pitch Euler angles have no rates: a thousand times the 1e-15 to which a chain of
/// joints rounds the axis of its tip.
inline constexpr double gimbal_lock = 1e-12;

/// One moving joint in modified Denavit-Hartenberg form (Craig): from the previous frame, tilt z about x,
/// translate to the joint's axis, then rotate about it or translate along it.
///
/// A frame is its axes X, Y, Z in the base frame and a point o:
///   o += a X + b Y
///   Z' = cos Z - sin Y,  Y' = cos Y + sin Z                              (tilt)
///   o += d Z'                                                            (a point on the joint's axis)
///   X' = cos(t) X + sin(t) Y',  Y'' = cos(t) Y' - sin(t) X               (rotation), t = multiplier q +
///   offset
/// The nearest multiple of a right angle in the tilt exchanges axes; the residual tilt, at most pi/4, is
/// three shears with three products instead of four (Y1 = Y + h Z, Z' = Z - sin Y1, Y' = Y1 + h Z'). A
/// prismatic joint rotates by a constant and translates o by t Z'. The sign changes of right angles are
/// folded into the constants: the joint's axis is sign Z'.
struct FoldedJoint {
  bool right_angle = false, tilts = false;           ///< the tilt has a right angle, a residual
  double half_tangent = 0, sine = 0;                 ///< of the residual tilt: h = tan(tilt/2), sin(tilt)
  double a = 0, b = 0, d = 0;                        ///< [m]
  bool has_a = false, has_b = false, has_d = false;  ///< not 0
  bool rotates = true;  ///< false: the rotation is the identity, or has no effect on the results
  bool prismatic = false;
  double rotation_cosine = 1, rotation_sine = 0;      ///< of a prismatic joint's constant rotation
  double multiplier = 1, offset = 0;                  ///< of the angle [rad], or of the translation [m]
  double quarter_multiplier = 0, quarter_offset = 0;  ///< of the angle in quarter turns
  std::size_t coordinate = 0;                         ///< index of the independent joint
  double sign = 1;
  bool own_point = true;  ///< false: the stored point of the previous joint lies on this axis, too
};

/// View of a FoldedChain for the batched kernels; matrices column-major.
struct FoldedPath {
  const FoldedJoint* joints;
  std::size_t count;
  const double *first_axes, *first_point;
  double axes_length;  ///< length of X, Y, Z: coordinates along them are in units of it
  double tip_x, tip_y;
  const double* tip_axes;
};

/// Ranges of the joints [rad or m].
struct SampledRanges {
  std::size_t joints;
  const double *lower, *width, *upper;
};

/// Kernels compiled once per instruction set (lanes/select_kernels.hpp). Batches: batch.hpp.
struct KinematicKernels {
  std::size_t lanes;
  std::size_t scratch_per_joint;  ///< doubles of `scratch` that `jacobians` needs
  /// @param signs  [joint]: FoldedJoint::sign
  void (*jacobians)(const FoldedPath&, const double* signs, const double* q, double* to, double* scratch);
  /// Sobol points, start ^ pattern as fractions of the ranges in units of 2^-53.
  /// @param start     [joint]: first point of the batch
  /// @param patterns  [joint][64]
  void (*sobol)(const SampledRanges&, const std::uint64_t* start, const std::uint64_t* patterns, double* to);
  /// Independent uniform points.
  /// @param keys  [joint]: random_key(seed, joint)
  void (*random)(const SampledRanges&, const std::uint64_t* keys, std::uint64_t first, double* to);
};

}  // namespace qerr
