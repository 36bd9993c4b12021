#pragma once

#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Contestants that copy `right` and change one figure slightly: the check must reject each of them.
std::vector<Contestant> spoiled(const Contestant& right);

}  // namespace qerr::bench
