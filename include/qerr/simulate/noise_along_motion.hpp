#pragma once

#include <Eigen/Core>

#include "qerr/bound/noise_in_motion.hpp"
#include "qerr/encoder/transmission.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// sigma of each encoder's quantization error behind a filter, along the motion, in quantization intervals
/// (theory behind `path_sigma`): what IPQN puts as ||H||_2/sqrt(12) for every encoder.
///
/// What the filter remembers of the time before the motion counts too: sines and constant velocities are
/// taken as having always run, moves and tables as having rested. Motions of more than 2^17 samples are
/// looked at in stretches spread evenly over them.
/// @param start  beginning of the motion that is left out [s]
/// @returns one per encoder
Eigen::VectorXd noise_along_motion(const Transmission&, const Motion&, const Autocorrelation&,
                                   double sample_rate, double start = 0);

}  // namespace qerr
