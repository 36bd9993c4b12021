#pragma once

#include <string>

namespace qerr {

/// A row of Table IV of the paper, in both interpretations. Lengths in metres.
///
/// Physical: resolution 2 pi l/(n G) of a point at distance l from a revolute joint with n G counts per turn.
/// As printed (paper, Eqs. 43 and 44): l/(n G), without the factor 2 pi. A prismatic joint has no such
/// factor. Threshold velocity: resolution times sample rate, which is one count per sample. Behind a coupling
/// C (joint angles = C * encoder angles) one count of encoder i moves joint j by |C_ji| times this; the row
/// is that of the encoder and the joint with the largest product.
struct ThresholdRow {
  std::string robot;
  std::string
      joint;  ///< the joint j with the largest l |C_ji| Delta_i; counts and ratio are those of encoder i
  double counts_per_rev = 0;
  double gear_ratio = 1;
  double coupling = 1;               ///< |C_ji|, a factor of both resolutions
  double length = 0;                 ///< [m]
  double sample_rate = 0;            ///< [Hz]
  double resolution = 0;             ///< [m]
  double resolution_as_printed = 0;  ///< [m]

  double threshold_velocity() const { return resolution * sample_rate; }  ///< [m/s]
  double threshold_velocity_as_printed() const { return resolution_as_printed * sample_rate; }
};

}  // namespace qerr
