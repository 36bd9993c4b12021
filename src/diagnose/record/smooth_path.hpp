#pragma once

#include <Eigen/Core>

namespace qerr {

/// Smoothed recorded path.
struct SmoothPath {
  Eigen::ArrayXd position, velocity;  ///< [unit], [unit/s]
  double noise = 0;                   ///< standard deviation of the white noise of the recorded values [unit]
  double residual_noise = 0;          ///< standard deviation of the noise that remains in `position` [unit]
};

/// Local cubic least-squares fits (Savitzky and Golay 1964, at the actual stamps). The window is the widest
/// whose residual does not exceed the noise that divided differences of order 4, 6 and 8 estimate: a wider
/// one would distort the path, and the distortion would be attributed to the encoder.
/// @param time  not decreasing, even or uneven [s]; rows with equal stamps get equal weight
/// @param log_resolution  step of the recorded values, a lower bound of their noise [unit]
SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution);

/// `noise` of the smooth path alone.
double noise_of_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution);

/// Direction of a joint's last motion: -1 or +1, 0 before the first motion. Reversals smaller than
/// `threshold` are treated as noise.
Eigen::ArrayXd direction_of_motion(const Eigen::ArrayXd& path, double threshold);

}  // namespace qerr
