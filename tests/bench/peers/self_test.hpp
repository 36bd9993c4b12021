#pragma once

#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Contestants that do what `right` does and then spoil one figure each, by little: none may be let through.
std::vector<Contestant> spoiled(const Contestant& right);

}  // namespace qerr::bench
