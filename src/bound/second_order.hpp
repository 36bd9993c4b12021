#pragma once

#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// The second-order remainders of `operational_error` that hold over the whole quantization box, as far as
/// they do not depend on the configuration. The position's is linear in the arms:
/// rho = position_constant + sum_k position_weights[k] |column k of J_v|, k over revolute joints.
struct SecondOrder {
  double position_constant = 0;
  Eigen::VectorXd position_weights;  ///< [moving joint]
  double rotation = 0;               ///< [rad], of one component of the rotation vector
  double rotation_angle = 0;         ///< [rad], bound of the whole angle

  explicit SecondOrder(const OperationalModel&);

  /// rho [m]. @param joints  of `joint_jacobian`
  double position(const Jacobian& joints) const;
};

}  // namespace qerr
