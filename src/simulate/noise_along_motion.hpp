#pragma once

#include <Eigen/Core>

#include "bound/noise_in_motion.hpp"
#include "qerr/encoder/transmission.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// Power of the filtered quantization error of each encoder in stretches of equal length along the motion
/// (theory: `path_sigma`), in squared quantization intervals. IPQN approximates it by ||H||_2^2/12.
///
/// The memory of the filter extends to times before the motion, where sines and constant velocities continue
/// and moves and tables are at standstill. Of motions with more than 2^17 samples, a part of every stretch is
/// evaluated.
/// @param start  initial part of the motion that is excluded [s]
/// @param most   largest number of stretches, a power of two; fewer if the motion has fewer samples or the
/// filter
///   a long memory
/// @returns stretches x encoders
Eigen::MatrixXd noise_power_along_motion(const Transmission&, const Motion&, const Autocorrelation&,
                                         double sample_rate, double start, std::size_t most);

/// Sigma of the filtered quantization error over the whole motion, in quantization intervals.
/// @returns one per encoder
Eigen::VectorXd noise_along_motion(const Transmission&, const Motion&, const Autocorrelation&,
                                   double sample_rate, double start = 0);

}  // namespace qerr
