#pragma once

#include <Eigen/Core>

#include "bound/noise_in_motion.hpp"
#include "qerr/encoder/transmission.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// Power of each encoder's quantization error behind a filter, in stretches of equal length along the motion
/// (theory behind `path_sigma`), in squared quantization intervals: what IPQN puts as ||H||_2^2/12.
///
/// What the filter remembers of the time before the motion counts too: sines and constant velocities are
/// taken as having always run, moves and tables as having rested. Of motions of more than 2^17 samples a part
/// of every stretch is looked at.
/// @param start  beginning of the motion that is left out [s]
/// @param most   stretches at most; there are fewer where the motion has fewer samples or the filter a long
///   memory, by powers of two
/// @returns stretches x encoders
Eigen::MatrixXd noise_power_along_motion(const Transmission&, const Motion&, const Autocorrelation&,
                                         double sample_rate, double start, std::size_t most);

/// sigma of the same over the whole motion, in quantization intervals.
/// @returns one per encoder
Eigen::VectorXd noise_along_motion(const Transmission&, const Motion&, const Autocorrelation&,
                                   double sample_rate, double start = 0);

}  // namespace qerr
