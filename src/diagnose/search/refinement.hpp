#pragma once

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Refines the shapes of chosen terms (rates, time constants, sizes of hystereses, linearizations) by a
/// Gauss-Newton step of all at once, and forgets what scans have found but no set has chosen.
/// @returns whether any shape changed by more than it matters
bool refine_shapes(const ErrorModel&, const Choice&, Scanned&);

}  // namespace qerr
