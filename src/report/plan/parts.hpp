#pragma once

#include <string>

#include "qerr/report/diagnosis_report.hpp"
#include "report/rows.hpp"

/// What the formats of a plan share.
namespace qerr {

/// SI unit of the parameter that states a planned effect's size; "" for a pure number.
std::string size_unit(const PlannedEffect&, bool prismatic);

/// An effect with its shaft, without its order: `eccentricity (joint)`.
std::string family_of(const Effect&);

RowsOf<PlannedJoint> rows(Of<PlannedJoint>);

}  // namespace qerr
