#pragma once

#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Candidate motions of every joint with the duration and rate of a given motion, in order of increasing
/// range: point-to-point moves at three speeds in both directions with dwells between them, and sums of
/// sines. Numbers are rounded to three digits.
///
/// Ranges and speeds are within the URDF's limits. Without limits a revolute joint moves by up to one
/// revolution to either side, another joint as far, and any joint as fast, as in the given motion.
/// @returns one list per joint; empty for joints whose range is unknown
std::vector<std::vector<JointMotion>> better_motions(const OperationalModel&, const Motion&);

}  // namespace qerr
