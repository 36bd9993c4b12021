#pragma once

#include <functional>

#include "design/choice_pool.hpp"

namespace qerr {

/// What a search looks for.
struct ChoiceRequest {
  std::vector<double> limits;                      ///< [figure]; +infinity: none
  std::int64_t most = std::int64_t{1} << 62;       ///< highest price
  std::size_t wanted = 2;                          ///< how many choices, 1 or 2
  std::vector<OptionChoice> known = {};            ///< to begin with, if they meet the limits
  std::vector<OptionChoice> excluded = {};         ///< not to be found
  double work = 1.5e10;                            ///< multiply-adds, about, after which the search ends
  std::function<void(double part)> progress = {};  ///< called with the part of `work` that is done
};

/// The choices found, least price first.
struct ChoiceResult {
  std::vector<OptionChoice> best;
  bool proven = true;      ///< no other choice precedes them
  std::int64_t bound = 0;  ///< lower bound of the price of all choices that meet the limits, if not proven
  double work = 0;
};

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
  bool meets(std::size_t figure, const OptionChoice&, double limit);
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
  ChoiceRequest request_;
  PermittedOptions all_;
  std::vector<Priced> best_;
  std::size_t cuts_at_refresh_ = 0;
  std::int64_t open_bound_ = 0;  // of the nodes that were left unexplored
  bool ended_ = false;
  double work_ = 0;
};

/// The figures that no choice brings to their limits: not met even with the least weight of every column.
/// Figures without sums are not among them.
std::vector<std::size_t> unreachable_figures(const ChoiceProblem&, const std::vector<double>& limits);

}  // namespace qerr
