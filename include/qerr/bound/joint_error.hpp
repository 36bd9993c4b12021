#pragma once

#include <Eigen/Core>

#include "qerr/bound/error_source.hpp"
#include "qerr/encoder/transmission.hpp"

namespace qerr {

/// Error of every independent joint, estimate - true, in chain order [rad or m].
struct JointError {
  Eigen::VectorXd mean;        ///< C m, m: mean errors of the encoders; 0 when all round to nearest
  Eigen::VectorXd half_width;  ///< 0.5 |C| Delta (paper, Eq. 3, carried through the coupling)
  Eigen::VectorXd worst_case;  ///< half_width + |mean|
  Eigen::VectorXd
      sigma;  ///< sqrt(diag(C diag(Delta^2/12) C^T)) (paper, Eq. 9, which is diagonal only for C = I)
};

/// Joint error of a transmission: bounds from the quantization intervals of its encoders, and from what other
/// sources add at joints and encoders: means and half widths add, variances add.
JointError joint_error(const Transmission&, const std::vector<ErrorSource>& = {});

}  // namespace qerr
