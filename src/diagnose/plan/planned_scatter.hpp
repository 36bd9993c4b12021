#pragma once

#include <vector>

#include "diagnose/plan/identifiability.hpp"

namespace qerr {

/// Sizes from which a record shows the effects that add random errors or widen the distribution of the
/// readings without shifting it: noise, jitter of the sampling, unequal quadrature states.
std::vector<PlannedEffect> planned_scatter(const PlannedRecord&, const Identifiability&, const PlanOptions&);

}  // namespace qerr
