#pragma once

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/select.hpp"

namespace qerr {

/// Adds the significant error that no catalogued effect explains: of tables over position and time and of
/// vibrations the one that improves the model most, if any does; drops names whose effect it absorbs.
void add_unnamed_residual(Explanation&, const Evidence&, const SelectOptions&);

}  // namespace qerr
