#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// What one encoder would record along a motion, rows that say the same taken together.
struct PlannedRecord {
  Evidence evidence;
  Eigen::ArrayXd weight;  ///< readings that a row stands for
};

/// Of every encoder, its joints having a reference.
/// @param noise  of the reference [counts]
/// @param most   rows that are looked at, evenly over the motion
std::vector<PlannedRecord> planned_records(const OperationalModel&, const std::vector<Effect>& present,
                                           const Motion&, double noise, Eigen::Index most);

}  // namespace qerr
