#pragma once

#include <vector>

#include "diagnose/plan/identifiability.hpp"

namespace qerr {

/// How well a record shows what widens the readings instead of moving them: noise, jitter of the clock,
/// unequal quadrature states.
std::vector<PlannedEffect> planned_scatter(const PlannedRecord&, const Sight&, const PlanOptions&);

}  // namespace qerr
