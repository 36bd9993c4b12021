#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Geometric Jacobian of the chain's own moving joints, mimics counted apart, at independent coordinates q.
///
/// Column k: [z_k x (p - o_k); z_k] for a revolute joint, [z_k; 0] for a prismatic one, all in the base
/// frame; linear rows first. `pose`, when given, receives the tip's pose.
/// @returns 6 x joints, rows [m/rad or 1] and [1/1]
Jacobian joint_jacobian(const Chain&, const Eigen::VectorXd& q, Eigen::Isometry3d* pose = nullptr);

/// Folds columns of moving joints into those of the independent coordinates: a mimic adds multiplier times
/// its column.
/// @param columns  m x joints
/// @returns m x independent
Eigen::MatrixXd to_independent(const Chain&, const Eigen::MatrixXd& columns);

/// Geometric Jacobian x' = J q' of the independent coordinates, linear rows first (paper, Eq. 15).
/// @returns 6 x independent
Jacobian jacobian(const Chain&, const Eigen::VectorXd& q);

}  // namespace qerr
