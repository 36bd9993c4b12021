#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "report/diagnosis/joint_residual.hpp"

namespace qerr {

/// What the page draws of a joint's residual, with few points [SI].
struct ResidualPicture {
  using Points = std::vector<std::pair<double, double>>;

  std::string joint, unit;
  double resolution = 0;  ///< of the encoder [unit]
  bool prismatic = false, in_time = false;
  Eigen::Index rows = 0;
  double rms_before = 0, rms_after = 0;
  bool corrected = false;  ///< a cause was subtracted
  Points before, after;    ///< over time, or over the row
  struct Side {            ///< rows with one direction of the motion
    Points before, after;  ///< over the reference's position
    Points fit, mean;      ///< mean of what was subtracted, and of what was before
  };
  std::array<Side, 3> sides;               ///< forward, backward, unknown
  Points by_count_before, by_count_after;  ///< means, over the count modulo `count_cycle`
  Points spectrum_before, spectrum_after;  ///< amplitude over the order
  double revolution = 0;                   ///< order of one period per revolution of the encoder
};

/// Readings with the same remainder have the same state of a line's signals and the same last bits.
inline constexpr int count_cycle = 64;

/// @param intervals  of each line
ResidualPicture residual_picture(const JointResidual&, std::size_t intervals);

}  // namespace qerr
