#pragma once

#include <Eigen/Core>

#include "qerr/bound/error_along_motion.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/encoder/transmission.hpp"

namespace qerr {

/// Error of every independent joint, estimate - true, in chain order [rad or m].
struct JointError {
  Eigen::VectorXd mean;        ///< C m with the encoders' mean errors m; 0 when all round to nearest
  Eigen::VectorXd half_width;  ///< 0.5 |C| Delta (paper, Eq. 3, carried through the coupling)
  Eigen::VectorXd worst_case;  ///< half_width + |mean|
  /// sqrt(diag(C diag(Delta^2/12) C^T)) (paper, Eq. 9, whose covariance is diagonal only for C = I).
  Eigen::VectorXd sigma;
};

/// Joint error of a transmission, from the quantization intervals of its encoders and the sources at joints
/// and encoders: means, half widths and variances add (displaced origins do not move a joint).
/// @param along_motion  of the joints, or null: its peak adds to half_width and its variance to that of sigma
JointError joint_error(const Transmission&, const std::vector<IndependentError>& = {},
                       const SignalMoments* along_motion = nullptr);

}  // namespace qerr
