#pragma once

#include "qerr/bound/effect_shares.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// How a motion uses the joints and the encoders: positions and velocities at its samples, and the efforts
/// that it takes where the robot has masses (inverse_dynamics.hpp). Of a motion of more than 1e5 samples as
/// many instants spread evenly over it; of its efforts 1e4. Ranges of positions and velocities reach to their
/// peaks between the instants, those of efforts do not.
/// @param margin  before and after the motion that is looked at too: a late reading is one of then [s]
RobotUsage usage_in_motion(const OperationalModel&, const Motion&, double margin = 0);

}  // namespace qerr
