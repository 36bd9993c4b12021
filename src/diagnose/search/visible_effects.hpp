#pragma once

#include <vector>

#include "diagnose/search/cause_search.hpp"
#include "diagnose/search/error_model.hpp"

namespace qerr {

/// For each effect that was not found, the size at which one of its terms would have passed the criterion
/// beside what was found, or what hides it.
std::vector<VisibleEffect> visible_effects(const ErrorModel&, const Choice&);

}  // namespace qerr
