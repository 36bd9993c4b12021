#pragma once

#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// Motions of the same length and rate that a joint could do instead, the modest ones first: moves at three
/// speeds to and fro with rests between, and sums of sines, over parts of what limits allow; rounded to
/// figures that a person writes.
///
/// Limits and speeds are the URDF's; where it has none, a joint goes as far and as fast as it does now, a
/// revolute one without limits one turn to either side.
/// @returns one list per joint; empty for joints that cannot be told how far they may go
std::vector<std::vector<JointMotion>> better_motions(const OperationalModel&, const Motion&);

}  // namespace qerr
