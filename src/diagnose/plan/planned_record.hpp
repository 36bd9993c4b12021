#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// The record of one encoder along a planned motion.
struct PlannedRecord {
  Evidence evidence;      ///< rows that are not independent are merged
  Eigen::ArrayXd weight;  ///< independent readings per row
};

/// Records of all encoders, with references at all joints.
/// @param noise      of the reference [counts]
/// @param most_rows  evaluated, evenly over the motion
std::vector<PlannedRecord> planned_records(const OperationalModel&, const std::vector<Effect>& present,
                                           const Motion&, double noise, Eigen::Index most_rows);

}  // namespace qerr
