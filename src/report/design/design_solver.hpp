#pragma once

#include "report/design/design_problem.hpp"

namespace qerr {

/// A choice of encoders behind one of the filter sets.
struct FoundDesign {
  std::int64_t cost = 0;
  std::size_t set = 0;
  OptionChoice choice;
  bool operator==(const FoundDesign&) const = default;
};

/// What is looked for among the encoders and filter sets.
struct DesignQuery {
  std::vector<double> limits;  ///< [requirement of the problem's base]
  std::int64_t most = std::int64_t{1} << 62;
  std::size_t wanted = 2;
  std::vector<FoundDesign> known = {}, excluded = {};
  double work = 1.5e10;
};

struct DesignFindings {
  std::vector<FoundDesign> best;
  bool proven = true;         ///< no other design is cheaper, or has less of the goal
  bool margin_proven = true;  ///< of those that cost as much, none has a better margin
  std::int64_t bound = 0;     ///< of the cost, if not proven
};

/// A requirement's value over a scale, of which the largest of several is to be least.
struct DesignGoal {
  std::size_t requirement = 0;
  double scale = 1;
};

/// Looks for designs of least cost, or of the least figure, in all filter sets.
class DesignSolver {
 public:
  DesignSolver(DesignProblem&, std::vector<FilterSet>, SearchProgress = {});
  DesignSolver(const DesignSolver&) = delete;
  DesignSolver& operator=(const DesignSolver&) = delete;

  const FilterSet& set(const FoundDesign& d) const { return sets_[d.set]; }
  const std::vector<FilterSet>& sets() const { return sets_; }
  const ChoiceProblem& problem(std::size_t set) { return searched(set).problem; }

  /// Designs by ascending cost; at equal costs by the filter set, and then by the options (EncoderSearch).
  /// Two designs differ in their encoders, or, where none is chosen, in their filters.
  DesignFindings find(const DesignQuery&);

  /// The best designs: of those with the least value of the goal, if there is one, the cheapest; of these the
  /// one whose largest value over its scale, over all `margins`, is least (the best margin); of these that
  /// with the least value of the first of them, then of the second, ...; and of these the first of `find`.
  /// Values within 1e-8 of one another are equal.
  /// @param goal  index of the requirement whose value is minimized, if any
  DesignFindings best(const DesignQuery&, std::optional<std::size_t> goal,
                      const std::vector<DesignGoal>& margins);

  /// The design whose largest value over its scale is least, and the query's limits of the goals lowered to
  /// it.
  std::optional<FoundDesign> least(const std::vector<DesignGoal>&, DesignQuery&, bool& proven);

  /// Whether the filters of a set meet the limits of their figures.
  bool filters_meet(std::size_t set, const std::vector<double>& limits) const;
  double value(const FoundDesign& d, std::size_t requirement) const { return largest(d, {{requirement, 1}}); }
  /// Largest value over its scale.
  double largest(const FoundDesign&, const std::vector<DesignGoal>&) const;

 private:
  struct Searched {
    ChoiceProblem problem;
    std::unique_ptr<EncoderSearch> search;
  };
  Searched& searched(std::size_t set);
  DesignFindings find_in(std::size_t set, const DesignQuery&);
  std::optional<FoundDesign> least_in(std::size_t set, const std::vector<DesignGoal>&, DesignQuery,
                                      bool& proven);
  double tie(std::size_t set, const std::vector<DesignGoal>&);
  FoundDesign with_best_margin(const FoundDesign& cheapest, DesignQuery,
                               const std::vector<DesignGoal>& margins, bool& proven);
  DesignFindings minimize_of_filter(std::size_t goal, const DesignQuery&);

  DesignProblem& problem_;
  std::vector<FilterSet> sets_;
  std::vector<std::unique_ptr<Searched>> searched_;
  bool any_encoder_ = false;
  SearchProgress progress_;
  std::size_t searches_ = 0;
};

/// The limits of all requirements: those of the spec, and none for the entries beyond `stated`.
std::vector<double> stated_limits(const Spec&, std::size_t stated);

/// The combinations of filters among which a design chooses.
struct FilterSets {
  std::vector<FilterSet> sets;         ///< the quietest first
  std::vector<std::string> obstacles;  ///< filters of which no candidate is within its limits, in sentences
};

/// The spec's filters, with the candidates of those that the request names in all combinations.
///
/// A candidate within a filter's limits is dropped if another one equals it in all of what the requirements
/// ask: ||H||_2 of sigma and the ratios of slow errors, ||H||_1 and |H(1)| of a worst case, and the quantity
/// that is minimized. Without encoders to choose, those of every family and order are kept
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
