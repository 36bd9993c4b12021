#pragma once

#include <vector>

#include "qerr/filter/filter.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// Initial part of a motion that statistics exclude [s]: `motion.settling`, or where it is not given, until
/// the transients of all filters have decayed to 1e-3, at most half of the motion.
double settling_time(const Motion&, const std::vector<Filter>&);

}  // namespace qerr
