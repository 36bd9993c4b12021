#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// Second-order remainders of the tip's pose over the whole quantization box, as far as the configuration
/// does not change them (`operational_error` says where they come from).
///
/// Of the position: rho = position + sum_k per_column_k |linear part of column k of the joint Jacobian|.
struct LinearizationRemainder {
  double position = 0;         ///< [m]
  Eigen::VectorXd per_column;  ///< of each moving joint, 0 of prismatic ones
  double rotation = 0;  ///< [rad], of one component of the rotation vector; infinite for boxes beyond pi
  double rotation_angle = 0;  ///< [rad], bound of the whole angle
};

/// @param largest  error of each independent joint [rad or m]
LinearizationRemainder linearization_remainder(const Chain&, const Eigen::VectorXd& largest);

}  // namespace qerr
