#pragma once

#include "diagnose/inference/tip/tip_select.hpp"

namespace qerr {

/// Puts better terms in the place of chosen ones until none is better, then tells what is as good.
void try_others(const OperationalModel&, TipSelection&);

}  // namespace qerr
