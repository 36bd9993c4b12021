#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace qerr {

/// The index of the chosen option of each joint.
using OptionChoice = std::vector<std::size_t>;

/// A column of non-negative numbers, one per configuration, and its weight by the option of one joint.
struct WeightedColumn {
  std::size_t joint = 0;
  const double* coefficients = nullptr;
  std::vector<double> weights;  ///< [option]
};

/// added + sum_k weight_k(option of column k's joint) * column k, at every configuration.
struct WeightedSum {
  std::vector<WeightedColumn> columns;
  double added = 0;
};

/// A figure of the requirements, as a function of the options of all joints: the statistic, over the
/// configurations, of the largest of its sums or, with `root`, of its square root.
///
/// As all coefficients are non-negative, the figure never grows when weights shrink: its value for the
/// smallest weight of each column is a lower bound of all choices. A worst case |A| h + |A m| of signed
/// columns A is the larger of two sums, with the weights h + m at A > 0 and h - m at A < 0, or these
/// exchanged; sigma is the root of one sum, with the coefficients A^2.
struct ChoiceFigure {
  enum class Over { least, mean, largest, percentile };
  Over over = Over::largest;
  double percentile = 0;  ///< fraction of the configurations
  bool root = false;
  std::vector<WeightedSum> sums;  ///< empty: only ChoiceProblem::judge knows the figure
  bool bound = false;             ///< the sums are a lower bound of the figure, which `judge` knows
  bool monotone = true;           ///< the figure never grows when weights shrink
  /// Relative accuracy with which the figure of the report may differ from that of the sums: within it of its
  /// limit, `judge` decides.
  double tolerance = 1e-9;
};

/// A linear inequality that every choice meeting a limit fulfills: constant + sum_j parts[offset_j + option]
/// <= the limit (its square, if `squared`).
struct ChoiceCut {
  std::size_t figure = 0;
  std::vector<double> parts;  ///< [options of all joints, one joint after the other]
  double constant = 0;
  bool squared = false;
};

/// The choice of one option per joint at least price, with limits of figures.
struct ChoiceProblem {
  struct Verdict {
    bool met = false;
    std::vector<ChoiceCut> cuts = {};  ///< that exclude the choice, if any are known
    double work = 0;                   ///< multiply-adds, about
  };

  std::vector<std::vector<std::int64_t>> prices;  ///< [joint][option], ascending
  std::size_t configurations = 0;
  std::vector<ChoiceFigure> figures;
  /// Decides a choice that meets what the sums know: figures without sums, those bounded by them, and those
  /// within their tolerance of a limit. May be empty if there are none.
  /// @param limits  [figure]
  std::function<Verdict(const OptionChoice&, const std::vector<double>& limits)> judge;

  std::size_t joints() const { return prices.size(); }
};

/// Index of the first option of every joint among all options, and their number.
std::vector<std::size_t> option_offsets(const ChoiceProblem&);

std::int64_t price_of(const ChoiceProblem&, const OptionChoice&);

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
