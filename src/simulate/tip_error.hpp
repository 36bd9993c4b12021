#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

/// Estimate minus true of every coordinate, from the two poses themselves [m or rad].
///
/// x y z: difference of the positions; rx ry rz: rotation vector of R_hat R^T; roll pitch yaw: difference of
/// the angles of R = Rz(yaw) Ry(pitch) Rx(roll), wrapped into [-pi, pi].
Eigen::VectorXd tip_error(const std::vector<Coordinate>&, const Eigen::Isometry3d& estimate,
                          const Eigen::Isometry3d& truth);

}  // namespace qerr
