#pragma once

#include <optional>

#include "design/choice_problem.hpp"

namespace qerr {

/// The weights of the columns of a figure's sums: [sum][column].
using SumWeights = std::vector<std::vector<double>>;

SumWeights weights_of(const ChoiceFigure&, const OptionChoice&);

/// The smallest weights that the permitted options of each joint have, column by column.
/// @param permitted  [options of all joints]
SumWeights least_weights(const ChoiceFigure&, const std::vector<std::size_t>& offsets,
                         const std::vector<char>& permitted);

/// The figure's value, its percentiles interpolated linearly between order statistics.
/// @pre the figure has sums
double figure_value(const ChoiceFigure&, const SumWeights&, std::size_t configurations);

/// Result of a comparison with a limit.
struct LimitTest {
  bool met = true;
  std::size_t worst = 0;  ///< not met: a configuration beyond the limit; of a percentile, the one at its rank
  std::vector<std::uint32_t> beyond =
      {};  ///< percentile, not met: more configurations beyond it than permitted
};

/// Whether the figure's value is at most the limit, decided as early as possible.
/// @param first  configuration at which to begin, such as that of the last failure
LimitTest compare_with_limit(const ChoiceFigure&, const SumWeights&, double limit, std::size_t configurations,
                             std::size_t first = 0);

/// The tangent of a mean, which is convex in its half widths or sigmas and homogeneous: every choice has at
/// least the tangent's value, and the choice of the weights has exactly this.
ChoiceCut tangent_of_mean(const ChoiceFigure&, std::size_t index, const ChoiceProblem&, const SumWeights&);

/// The figure's sum at one configuration: its largest one there for the weights.
ChoiceCut cut_at_configuration(const ChoiceFigure&, std::size_t index, const ChoiceProblem&,
                               const SumWeights&, std::size_t configuration);

}  // namespace qerr
