#pragma once

#include "report/design/design_problem.hpp"

namespace qerr {

/// One choice for each filter of the spec.
struct FilterSet {
  std::vector<NamedFilter> filters;
  std::vector<DesignedFilter> designed;  ///< those that are chosen
};

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
  bool proven = true;
  std::int64_t bound = 0;  ///< of the cost, if not proven
};

/// Looks for designs of least cost, or of the least figure, in all filter sets.
class DesignSolver {
 public:
  DesignSolver(DesignProblem&, std::vector<FilterSet>);
  DesignSolver(const DesignSolver&) = delete;
  DesignSolver& operator=(const DesignSolver&) = delete;

  const FilterSet& set(const FoundDesign& d) const { return sets_[d.set]; }
  const std::vector<FilterSet>& sets() const { return sets_; }
  const ChoiceProblem& problem(std::size_t set) { return searched(set).problem; }

  /// Designs by ascending cost; at equal costs by the filter set, and then by the options (EncoderSearch).
  /// Two designs differ in their encoders, or, where none is chosen, in their filters.
  DesignFindings find(const DesignQuery&);

  /// The design with the least value of a requirement's quantity, of these the cheapest; its runner-up.
  /// @param goal  index of the requirement
  DesignFindings minimize(std::size_t goal, const DesignQuery&);

  /// Whether the filters of a set meet the limits of their figures.
  bool filters_meet(std::size_t set, const std::vector<double>& limits) const;
  double value(const FoundDesign&, std::size_t requirement) const;

 private:
  struct Searched {
    ChoiceProblem problem;
    std::unique_ptr<EncoderSearch> search;
  };
  Searched& searched(std::size_t set);
  DesignFindings find_in(std::size_t set, const DesignQuery&);
  std::optional<FoundDesign> least_in(std::size_t set, std::size_t goal, DesignQuery, bool& proven);
  DesignFindings minimize_of_filter(std::size_t goal, const DesignQuery&);

  DesignProblem& problem_;
  std::vector<FilterSet> sets_;
  std::vector<std::unique_ptr<Searched>> searched_;
  bool any_encoder_ = false;
};

/// The limits of all requirements: those of the spec, and none for the entries beyond `stated`.
std::vector<double> stated_limits(const Spec&, std::size_t stated);

}  // namespace qerr
