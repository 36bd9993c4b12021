#pragma once

#include <string>

namespace qerr {

/// A row of the paper's Table IV, in both readings. Lengths in metres.
///
/// Physical: resolution 2 pi l/(n G), as a revolute joint of n G counts a turn moves a point at distance l.
/// As printed (paper, Eqs. 43 and 44): l/(n G), which lacks the 2 pi. A prismatic joint has no such factor.
/// Threshold velocity: resolution times sample rate, one count per sample.
struct ThresholdRow {
  std::string robot;
  std::string joint;  ///< the joint with the largest l Delta
  double counts_per_rev = 0;
  double gear_ratio = 1;
  double length = 0;                 ///< [m]
  double sample_rate = 0;            ///< [Hz]
  double resolution = 0;             ///< [m]
  double resolution_as_printed = 0;  ///< [m]

  double threshold_velocity() const { return resolution * sample_rate; }  ///< [m/s]
  double threshold_velocity_as_printed() const { return resolution_as_printed * sample_rate; }
};

}  // namespace qerr
