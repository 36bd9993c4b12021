#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// Second-order remainders of the tip's pose over the whole quantization box (derivation:
/// `operational_error`), in terms that do not depend on the configuration.
///
/// Position: rho = position + sum_k per_column_k |linear part of column k of the joint Jacobian|.
struct LinearizationRemainder {
  double position = 0;         ///< [m]
  Eigen::VectorXd per_column;  ///< [moving joint]; 0 for prismatic ones
  double rotation = 0;        ///< of one component of the rotation vector; infinite for boxes beyond pi [rad]
  double rotation_angle = 0;  ///< bound of the rotation angle [rad]
};

/// @param largest  error of each independent joint [rad or m]
LinearizationRemainder linearization_remainder(const Chain&, const Eigen::VectorXd& largest);

}  // namespace qerr
