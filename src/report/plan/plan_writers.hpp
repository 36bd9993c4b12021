#pragma once

#include <string>

#include "qerr/report/plan_report.hpp"
#include "qerr/report/write.hpp"

/// What the formats offer to plan_report.cpp, one function per format.
namespace qerr {

std::string to_json(const PlanReport&);
std::string to_csv(const PlanReport&);
std::string to_table(const PlanReport&, const Style&);

/// SI unit of the parameter that a planned effect's size is of, "" for a pure number.
std::string size_unit(const PlannedEffect&, bool prismatic);

/// An effect as people tell it from its kin: `eccentricity (joint)`, without its order.
std::string family_of(const Effect&);

}  // namespace qerr
