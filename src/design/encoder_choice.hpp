#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
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

/// The options that a search still permits: [options of all joints].
using PermittedOptions = std::vector<char>;

/// Configurations of a figure of a percentile at which choices have failed, and its columns there. More of
/// them beyond the limit than the percentile permits exclude a choice; they are far fewer than all
/// configurations.
class FailureSample {
 public:
  FailureSample(const ChoiceFigure&, std::size_t configurations);

  void add(const std::vector<std::uint32_t>& configurations);
  std::size_t size() const { return members_.size(); }

  /// Removes the options with which more configurations than permitted are beyond the limit even if all other
  /// joints have the least of their permitted weights.
  /// @returns whether a choice is left
  bool restrict(double limit, const std::vector<std::size_t>& offsets, PermittedOptions&, double& work) const;

 private:
  struct Values;
  bool fails(const Values&, double limit) const;
  void restrict_joint(std::size_t joint, const Values& least, const SumWeights&, double limit,
                      const std::vector<std::size_t>& offsets, PermittedOptions&, double& work) const;

  const ChoiceFigure* figure_;
  std::size_t permitted_;
  std::vector<std::uint32_t> members_;                     // ascending
  std::vector<std::vector<std::vector<double>>> columns_;  // [sum][column][member]
};

/// Cuts, the Lagrangian bound of the price that follows from them, and the removal of options by both.
class CutPool {
 public:
  explicit CutPool(const ChoiceProblem&);

  /// @param guide  not valid for all choices: only `usage` regards it
  void add(ChoiceCut, bool guide = false);
  std::size_t size() const { return cuts_.size(); }

  /// The limits of the figures, and the options that are looked at, from now on.
  void begin(const std::vector<double>& limits, const PermittedOptions&);

  /// Removes the options that no choice within the cuts and at most `most` in price has.
  /// @param bound  receives a lower bound of the price
  /// @returns whether a choice is left
  bool restrict(PermittedOptions&, std::int64_t most, std::int64_t& bound, double& work) const;

  /// Improves the multipliers of the Lagrangian min price + sum_r multiplier_r (cut_r - limit_r) over single
  /// options, whose maximum is a lower bound of the price.
  /// @param target  a price that is known to be reached, or none
  void improve_multipliers(const PermittedOptions&, std::optional<std::int64_t> target, double& work);

  /// Largest part of a limit that a choice uses, over all cuts and guides; above 1 it is beyond one.
  double usage(const OptionChoice&) const;

 private:
  struct Row {
    ChoiceCut cut;
    bool guide;
    double room, scale;  // the limit less the constant; parts are compared with room in units of scale
  };
  void set_room(Row&) const;
  double reduced(std::size_t option) const { return price_[option] + reduction_[option]; }
  std::int64_t rounded_up(double bound) const;
  bool remove_by_cuts(PermittedOptions&, bool& changed, double& work) const;
  bool remove_by_price(PermittedOptions&, std::int64_t most, std::int64_t& bound, bool& changed) const;

  std::vector<std::size_t> offsets_;
  std::vector<std::vector<std::size_t>> options_;  // [joint]: those that are looked at
  std::size_t count_ = 0;                          // of all of them
  std::vector<double> price_;                      // [option]
  std::int64_t base_ = 0, step_ = 1;               // every price of a choice is base + k step
  std::vector<double> limits_;
  std::vector<double> tolerances_;
  std::vector<Row> cuts_;
  std::vector<double> multipliers_;  // [cut]
  std::vector<double> reduction_;    // [option]: sum of multiplier * part / scale
  double reduction_of_rooms_ = 0;
};

/// What a search looks for: choices of encoders, or designs, which have filters, too.
template <class Choice>
struct SearchRequest {
  std::vector<double> limits;                      ///< [figure]; +infinity: none
  std::int64_t most = std::int64_t{1} << 62;       ///< highest price
  std::size_t wanted = 2;                          ///< how many choices, 1 or 2
  std::vector<Choice> known = {};                  ///< to begin with, if they meet the limits
  std::vector<Choice> excluded = {};               ///< not to be found
  double work = 1.5e10;                            ///< multiply-adds, about, after which the search ends
  std::function<void(double part)> progress = {};  ///< called with the part of `work` that is done
};
using ChoiceRequest = SearchRequest<OptionChoice>;

/// The choices found, least price first.
template <class Choice>
struct SearchResult {
  std::vector<Choice> best;
  bool proven = true;      ///< no other choice precedes them
  std::int64_t bound = 0;  ///< lower bound of the price of all choices that meet the limits, if not proven
  double work = 0;
};
using ChoiceResult = SearchResult<OptionChoice>;

/// Least-price choice of an option for every joint, by branch and bound, with proof.
///
/// Joints are decided in their order, options by ascending price, depth first. Choices are ordered by price
/// and, at equal prices, by the indices of their options, the first joint's first: the result is the
/// beginning of the list of all choices that meet the limits, and depends on nothing else.
///
/// A node is bounded by linear cuts (`CutPool`): a choice that fails a limit leaves the inequality of the
/// configuration at which it fails, or the tangent of the mean; by samples of configurations
/// (`FailureSample`) for percentiles; and by the Lagrangian of the cuts for the price. All of them hold for
/// every choice of the node. All configurations are evaluated only where every joint is decided.
///
/// Cuts and samples are kept from one search to the next, which may have other limits.
class EncoderSearch {
 public:
  /// The problem must outlive the search, whose columns it borrows.
  explicit EncoderSearch(const ChoiceProblem&);
  EncoderSearch(const EncoderSearch&) = delete;
  EncoderSearch& operator=(const EncoderSearch&) = delete;

  ChoiceResult find(const ChoiceRequest&);

 private:
  using Priced = std::pair<std::int64_t, OptionChoice>;
  enum class Leaf { met, failed };

  void begin(const ChoiceRequest&);
  PermittedOptions undominated(std::size_t kept) const;
  bool dominates(std::size_t joint, std::size_t a, std::size_t b) const;
  Leaf evaluate(const OptionChoice&);
  /// @param learning  whether a limit that is not met becomes a cut
  bool meets(std::size_t figure, const OptionChoice&, double limit, bool learning);
  void learn(std::size_t figure, const SumWeights&, const LimitTest&);
  bool keep(const OptionChoice&);
  std::int64_t most() const;
  bool cannot_precede(const PermittedOptions&, std::int64_t bound) const;
  bool restrict(PermittedOptions&, std::int64_t& bound);
  void explore(PermittedOptions);
  void find_first(const PermittedOptions&);
  std::optional<OptionChoice> guided_choice(const PermittedOptions&) const;
  void cheapen();
  void refresh_multipliers();

  const ChoiceProblem& problem_;
  std::vector<std::size_t> offsets_;
  CutPool cuts_;
  std::vector<FailureSample> samples_;     // [figure]
  std::vector<std::size_t> last_failure_;  // [figure]: configuration
  /// The least limit that a figure is known to meet, and the largest of which a cut says that it does not.
  struct Compared {
    double met = std::numeric_limits<double>::infinity(), failed = -met;
  };
  std::map<OptionChoice, std::vector<Compared>>
      compared_;            // [figure], of choices that met all limits of a search
  std::size_t failed_ = 0;  // figure that was not met last: it is compared first
  ChoiceRequest request_;
  PermittedOptions all_;
  std::vector<Priced> best_;
  std::size_t cuts_at_refresh_ = 0;
  std::int64_t open_bound_ = 0;  // of the nodes that were left unexplored
  bool ended_ = false;
  double work_ = 0;
};

}  // namespace qerr
