#pragma once

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/select.hpp"

namespace qerr {

/// Adds something real that no named cause makes: of tables of position and time and of vibrations the one
/// that improves the model most, if one does; and drops the names that were its shadows.
void add_remainder(Explanation&, const Evidence&, const SelectOptions&);

}  // namespace qerr
