#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Tracking error of a filter along a motion: its output for the tip's true position, minus the true
/// derivative of that at the same instant. It is what lag and ripple of the filter do to an encoder without
/// errors.
struct TrackingMoments {
  double mean = 0, variance = 0, peak = 0;  ///< over the samples that the filter uses after the settling
  /// Covariance with the filtered errors of the effects. Quantization adds nothing: its mean over the
  /// position of the encoder's zero is the same at every sample.
  double with_effects = 0;
};

/// The filter has settled to the motion: it starts at a time before 0 by the settling, through which sines
/// and velocities are continued, and moves and tables stand still.
/// @param settling  initial part that does not count [s]
/// @pre the rates of the filters divide that of the motion
/// @returns [coordinate]: of x y z, in the axes of the model; NaN for rotations, whose vector is no
/// derivative, and for third and higher derivatives
std::vector<TrackingMoments> tracking_along_motion(const OperationalModel&, const std::vector<Effect>&,
                                                   const Motion&, const Filter&, double settling);

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
