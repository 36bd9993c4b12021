#pragma once

#include "report/design/design_solver.hpp"

namespace qerr {

/// The combinations of filters among which a design chooses.
struct FilterSets {
  std::vector<FilterSet> sets;         ///< the quietest first
  std::vector<std::string> obstacles;  ///< filters of which no candidate is within its limits, in sentences
};

/// The spec's filters, with the candidates of those that the request names in all combinations.
///
/// Of the candidates within a filter's limits only those matter that no other one equals in all of what the
/// requirements ask: ||H||_2 of sigma and the ratios of slow errors, ||H||_1 and |H(1)| of a worst case, and
/// the quantity that is minimized. Without encoders to choose, those of every family and order are kept
/// apart, so that there is a runner-up.
/// @param limits  of the requirements of the problem's base
/// @param goal    index of the requirement whose quantity is minimized, if any
/// @throws Error (input) if there are more than 2000 combinations
FilterSets filter_sets(const DesignProblem&, const DesignRequest&, const std::vector<double>& limits,
                       std::optional<std::size_t> goal);

/// The change of a spec that gives a filter its chosen low-pass.
SpecChange lowpass_change(const DesignedFilter&);

/// Adds the quietest filter of the same tracking error, if the filter's band is known.
void compare_with_best(DesignedFilter&);

}  // namespace qerr
