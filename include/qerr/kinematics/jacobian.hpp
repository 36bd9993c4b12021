#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Geometric Jacobian of the chain's moving joints (a mimic has a column of its own) at independent
/// coordinates q.
///
/// Column k: [z_k x (p - o_k); z_k] for a revolute joint, [z_k; 0] for a prismatic one, all in the base
/// frame; linear rows first.
/// @param pose  receives the pose of the tip; may be null
/// @returns 6 x joints; linear rows [m/rad or 1], angular rows [1 or 0]
Jacobian joint_jacobian(const Chain&, const Eigen::VectorXd& q, Eigen::Isometry3d* pose = nullptr);

/// Columns of the independent coordinates: the sum of multiplier times column over the joints that each one
/// moves.
/// @param columns  m x joints
/// @returns m x independent
Eigen::MatrixXd to_independent(const Chain&, const Eigen::MatrixXd& columns);

/// Geometric Jacobian x' = J q' of the independent coordinates, linear rows first (paper, Eq. 15).
/// @returns 6 x independent
Jacobian jacobian(const Chain&, const Eigen::VectorXd& q);

}  // namespace qerr
