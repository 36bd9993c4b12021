#pragma once

#include "diagnose/inference/tip/tip_select.hpp"

namespace qerr {

/// Replaces chosen terms by better ones until none is better, then lists the terms that fit as well.
void find_tip_alternatives(const OperationalModel&, TipSelection&);

}  // namespace qerr
