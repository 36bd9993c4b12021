#pragma once

#include "report/design/design_solver.hpp"

namespace qerr {

/// The combinations of filters among which a design chooses: the spec's filters, with the candidates of those
/// that the request names in all combinations. The quietest come first.
/// @param goal  index of the requirement whose quantity is minimized, if any
/// @throws Error (input) if no candidate meets the limits of a filter
std::vector<FilterSet> filter_sets(const Spec&, const DesignRequest&, std::optional<std::size_t> goal);

/// The change of a spec that gives a filter its chosen low-pass.
SpecChange lowpass_change(const DesignedFilter&);

}  // namespace qerr
