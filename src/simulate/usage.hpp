#pragma once

#include "qerr/bound/effect_shares.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Usage of joints and encoders by a motion: positions and velocities at its samples, and efforts by inverse
/// dynamics if the robot has masses. Means are over the samples after `motion.settling`, ranges over all. At
/// most 1e5 samples (1e4 for efforts), evenly spaced over the motion, are evaluated. Ranges of positions and
/// velocities include a bound on their peaks between the samples, and positions half a count for the unknown
/// zero of the encoder; those of efforts do not.
/// @param margin  time before and after the motion that the ranges include, for delayed samples [s]
RobotUsage usage_in_motion(const OperationalModel&, const Motion&, double margin = 0);

}  // namespace qerr
