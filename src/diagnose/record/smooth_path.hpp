#pragma once

#include <Eigen/Core>

namespace qerr {

/// A recorded path without its noise.
struct SmoothPath {
  Eigen::ArrayXd position, velocity;  ///< [unit], [unit/s]
  double noise = 0;                   ///< standard deviation of the recorded numbers' white noise [unit]
  double residual_noise = 0;          ///< standard deviation of what is left of it in the position [unit]
};

/// Local cubic fits (Savitzky and Golay, at the actual stamps) over the widest window whose residual is still
/// no more than the noise that divided differences of order 4, 6 and 8 show: a wider one would bend the path,
/// and a bent path is found to be an error of the encoder.
/// @param time  not decreasing, even or uneven [s]; samples of one stamp share what they have
/// @param grid  step of the recorded numbers, the least noise there is [unit]
SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double grid);

/// `noise` of the smooth path alone.
double noise_of_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double grid);

/// Side on which a joint was last pushed, -1 or +1, 0 before its first motion: reversals smaller than
/// `threshold` are noise.
Eigen::ArrayXd direction_of_motion(const Eigen::ArrayXd& path, double threshold);

}  // namespace qerr
