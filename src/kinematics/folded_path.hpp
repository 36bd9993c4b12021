#pragma once

#include <cstddef>

// Files that are compiled for processors of their own kind include this: neither Eigen nor the standard
// library's containers, whose code the linker would share with everyone.

namespace qerr {

/// One moving joint in modified Denavit-Hartenberg form (Craig): from the frame before, tilt z about x, step
/// to the joint's axis, then turn about it, or slide along it.
///
/// Frames are kept as their axes X, Y, Z in the base frame and a point o:
///   o += a X + b Y
///   Z' = cos Z - sin Y,  Y' = cos Y + sin Z                              (tilt)
///   o += d Z'                                                            (the joint's axis passes here)
///   X' = cos(t) X + sin(t) Y',  Y'' = cos(t) Y' - sin(t) X               (turn), t = multiplier q + offset
/// Of the tilt the nearest multiple of a right angle is taken by exchanging axes; the rest, at most pi/4, in
/// three shears, which take three products instead of four (Y1 = Y + h Z, Z' = Z - sin Y1, Y' = Y1 + h Z').
/// A prismatic joint turns by a constant (turn_cosine, turn_sine) and slides o by t Z'. Signs that a right
/// angle would put on an axis are carried into the numbers instead: the axis of the joint is sign Z'.
struct FoldedJoint {
  bool right = false, tilts = false;                 ///< by a right angle, and by a rest
  double half_tangent = 0, sine = 0;                 ///< of the rest: h = tan(rest/2), and its sine
  double a = 0, b = 0, d = 0;                        ///< [m]
  bool has_a = false, has_b = false, has_d = false;  ///< these are not 0
  bool turns = true;  ///< false: the turn is by nothing, or changes nothing that is asked for
  bool prismatic = false;
  double turn_cosine = 1, turn_sine = 0;              ///< of a prismatic joint's constant turn
  double multiplier = 1, offset = 0;                  ///< of the angle [rad], or of the slide [m]
  double quarter_multiplier = 0, quarter_offset = 0;  ///< the same of the angle in quarter turns
  std::size_t coordinate = 0;                         ///< index of the independent joint
  double sign = 1;
  bool own_point = true;  ///< false: the point kept of the joint before lies on this one's axis, too
};

/// A folded chain (folded_chain.hpp) as the batched kernels take it. Matrices stand column by column.
struct FoldedPath {
  const FoldedJoint* joints;
  std::size_t count;
  const double *first_axes, *first_point;
  double axes_length;  ///< of X, Y, Z: lengths along them count in it
  bool upright;        ///< first_axes is a multiple of the identity
  bool level;  ///< and the second joint turns about an axis at right angles to the first one's, which turns
  double tip_x, tip_y;
  const double* tip_axes;
};

}  // namespace qerr
