#pragma once

#include <vector>

#include "diagnose/inference/tip/tip_model.hpp"

namespace qerr {

/// Number of orders and times that a scan at the tip tests, for the correction of its p-value.
inline constexpr int scanned_at_tip = 600;

/// What the model may be extended by: the catalogue, tilts of axes, and what a scan of the present scores
/// suggests. Nothing that it has.
std::vector<TipTerm> tip_candidates(const TipModel&);

/// Whether the model has this cause already.
bool chosen(const TipModel&, const TipTerm&);

}  // namespace qerr
