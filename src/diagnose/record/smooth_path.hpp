#pragma once

#include <Eigen/Core>

#include "qerr/simulate/log.hpp"

namespace qerr {

/// Smoothed recorded path.
struct SmoothPath {
  Eigen::ArrayXd position, velocity;  ///< [unit], [unit/s]
  Eigen::ArrayXd acceleration;  ///< [unit/s^2]; empty without a path, or if only three samples would give it
  double noise = 0;             ///< standard deviation of the white noise of the recorded values [unit]
  double residual_noise = 0;    ///< standard deviation of the noise that remains in `position` [unit]
};

/// Local cubic least-squares fits (Savitzky and Golay 1964, at the actual stamps). The window is the widest
/// whose residual does not exceed the noise that divided differences of order 4, 6 and 8 estimate: a wider
/// one would distort the path, and the distortion would be attributed to the encoder.
/// Where five samples distort it already, a reference at even stamps has the rates of the polynomial through
/// nine, which would amplify the steps of counts and errors of stamps.
/// @param time  not decreasing, even or uneven [s]; rows with equal stamps get equal weight
/// @param log_resolution  step of the recorded values, a lower bound of their noise [unit]
/// @param smooth_rates  keep to cubics: of counts and loads, whose derivatives must not amplify steps
SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution,
                       bool smooth_rates = false);

/// The path by cubics over sections of the record, each the longest of halves of halves that leaves no more
/// than noise. Where the motion is even it has less noise than any window, but corners where sections meet:
/// what an encoder reads along it has the beats of its rounding, which the noise of a window would blur.
/// @param smooth  what sections of few rows have
/// @param noise   of the recorded values [unit]
Eigen::ArrayXd sectioned_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded,
                              const Eigen::ArrayXd& smooth, double noise);

/// The path at any instant: cubic between its rows; beyond its ends it keeps the acceleration that it had
/// over as long a time before them.
/// @param time  increasing [s]
/// @param row  the row before the previous instant, or 0, and then that before this one: instants that follow
///   the rows need no search
double position_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path, const Eigen::ArrayXd& velocity,
                   double instant, Eigen::Index& row);
double position_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path, const Eigen::ArrayXd& velocity,
                   double instant);

/// `noise` of the smooth path alone.
double noise_of_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution);

/// Standard deviation of the noise of a column whose values are interpolated between samples (LogTable), in
/// the mean of some rows: of the samples' own white noise, the part that cubics through four of them leave; 0
/// without samples.
/// @param time  of the rows, ascending [s]
double noise_between(const LogColumn&, const Eigen::ArrayXd& time);

/// Direction of a joint's last motion: -1 or +1, 0 before the first motion. Reversals smaller than
/// `threshold` are treated as noise.
Eigen::ArrayXd direction_of_motion(const Eigen::ArrayXd& path, double threshold);

/// Direction of motion where readings show what happens while the joint rests at a reversal: a motor that
/// crosses the play of a gear does so at some time of the rest. The direction changes there, where the
/// reading passes the middle between its values at both ends of the rest; it is 0 while the reading is in
/// between.
/// @param direction  by the path alone
/// @param still      motion up to which the joint rests [unit of the path]
/// @param step       smallest difference of readings that counts [the same]
Eigen::ArrayXd direction_with_readings(const Eigen::ArrayXd& path, const Eigen::ArrayXd& measured,
                                       Eigen::ArrayXd direction, double still, double step);

}  // namespace qerr
