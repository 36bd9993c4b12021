#pragma once

#include <vector>

#include "diagnose/terms/term.hpp"

namespace qerr {

/// Offsets, gain and phase of a line's sine and cosine (Heydemann), whole and clipped: what the effect itself
/// makes of the path, about the present parameters.
std::vector<Term> subdivision_terms(const Evidence&);

}  // namespace qerr
