#pragma once

#include <string>

#include "qerr/report/analysis.hpp"

namespace qerr {

/// `velocity.x.sigma p99 is 1.20 mm/s, at most 1.00 mm/s is required`.
std::string verdict(const Requirement&, const RequirementResult&);

}  // namespace qerr
