#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

inline constexpr double standard_gravity = 9.80665;  ///< along -z of the base frame [m/s^2]

/// Torques and forces that the joints must exert for a motion, from the inertias of the URDF: gravity,
/// acceleration, centrifugal and Coriolis terms (Newton and Euler, base to tip and back). No friction, no
/// rotor inertia.
///
/// @param q, velocity, acceleration  of the independent coordinates [rad or m, per s, per s^2]
/// @returns one per independent coordinate [N m or N]; a mimic's share is carried to its master by its
/// multiplier
Eigen::VectorXd inverse_dynamics(const Chain&, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                                 const Eigen::VectorXd& acceleration);

/// Whether the URDF gives any mass beyond the base.
bool has_masses(const Chain&);

}  // namespace qerr
