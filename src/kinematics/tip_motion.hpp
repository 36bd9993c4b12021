#pragma once

#include <Eigen/Geometry>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// Motion of the tip in the base frame at one instant.
struct TipMotion {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< of the tip's origin: J q' [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< J q'' + J' q' [m/s^2]
};

/// Forward recursion along the chain (Siciliano et al., Robotics, 2009, Sec. 7.5.1).
/// @param q, velocity, acceleration  of the independent joints [rad or m, per s, per s^2]
TipMotion tip_motion(const Chain&, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                     const Eigen::VectorXd& acceleration);

}  // namespace qerr
