#pragma once

#include <string>

#include "qerr/report/plan_report.hpp"

/// What the formats of a plan share.
namespace qerr {

/// SI unit of the parameter that a planned effect's size is of, "" for a pure number.
std::string size_unit(const PlannedEffect&, bool prismatic);

/// An effect as people tell it from its kin: `eccentricity (joint)`, without its order.
std::string family_of(const Effect&);

}  // namespace qerr
