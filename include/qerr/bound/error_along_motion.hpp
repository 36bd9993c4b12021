#pragma once

#include <Eigen/Core>
#include <vector>

namespace qerr {

/// Mean, largest magnitude and covariance of signals over a record.
struct SignalMoments {
  Eigen::VectorXd mean, peak;
  Eigen::MatrixXd covariance;  ///< about the mean
};

/// Error, estimate - true, that effects add along one motion, without quantization: a known signal, the same
/// in every run, and independent of the sampled configurations.
///
/// An effect behind the quantizer that multiplies counts also multiplies the quantization error, which is not
/// part of this signal.
struct ErrorAlongMotion {
  SignalMoments joints;  ///< of the independent joints [rad or m]
  SignalMoments tip;     ///< of the model's coordinates, then its signals of other kinds [m or rad]
  std::vector<SignalMoments> filtered;  ///< [filter]: the same signals behind it [m/s, rad/s, ...]
};

}  // namespace qerr
