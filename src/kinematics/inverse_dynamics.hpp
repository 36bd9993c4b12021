#pragma once

#include <Eigen/Core>

#include "qerr/kinematics/chain.hpp"

namespace qerr {

inline constexpr double standard_gravity = 9.80665;  ///< along -z of the base frame [m/s^2]

/// Joint torques and forces of a motion (recursive Newton-Euler) from the inertias of the URDF: gravity,
/// inertial, centrifugal and Coriolis terms, without friction and rotor inertia.
///
/// @param q, velocity, acceleration  of the independent coordinates [rad or m, per s, per s^2]
/// @returns one per independent coordinate [N m or N]; the effort of a mimic acts on
/// its master times the multiplier
Eigen::VectorXd inverse_dynamics(const Chain&, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                                 const Eigen::VectorXd& acceleration);

/// Inertia at the coordinate of an independent joint, all others at rest: the diagonal element of the mass
/// matrix, twice the kinetic energy at unit velocity [kg m^2 or kg].
double inertia_at(const Chain&, std::size_t joint, const Eigen::VectorXd& q);

/// Whether any moving link of the chain has a mass.
bool has_masses(const Chain&);

}  // namespace qerr
