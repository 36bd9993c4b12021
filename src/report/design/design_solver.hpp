#pragma once

#include <deque>
#include <map>
#include <memory>
#include <tuple>

#include "bound/error_columns.hpp"
#include "design/encoder_choice.hpp"
#include "input/design_request.hpp"
#include "input/spec_variants.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/design_report.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"

namespace qerr {

/// The weights of the columns for every option of every joint, the other joints being as in the spec.
struct OptionWeights {
  ErrorWeights stated;                             ///< of the spec itself
  std::vector<std::vector<ErrorWeights>> options;  ///< [joint][option]
  std::vector<std::size_t> owners;                 ///< [column]: the joint whose options change it, else any
  bool biased = false;                             ///< an option's errors have a mean
  bool along_motion = false;                       ///< options change what effects add along the motion
};

/// Finds `owners`, `biased` and `along_motion`.
/// @throws Error (input) if the options of two joints change one column: their errors would not add
void find_owners(OptionWeights&, const Spec&);

/// The figures of requirements as weighted sums over columns of errors.
class FigureSums {
 public:
  /// @param spec, columns  must outlive it
  FigureSums(const Spec& spec, const ErrorColumns& columns) : spec_(spec), columns_(columns) {}
  FigureSums(const FigureSums&) = delete;
  FigureSums& operator=(const FigureSums&) = delete;

  /// The figure borrows coefficients of this object.
  ///
  /// The worst case of a length is bounded from below by its component in one direction at each
  /// configuration: that of the largest length for the reference, and by the components along the axes.
  /// @param reference  a choice
  ChoiceFigure figure(const Requirement&, const OptionWeights&, const OptionChoice& reference);

 private:
  enum class ColumnPart { magnitude, square, positive, negative };

  WeightedSum sigma_sum(const Requirement&, const OptionWeights&);
  std::vector<WeightedSum> worst_sums(const Requirement&, const OptionWeights&, std::size_t coordinate);
  std::vector<WeightedSum> length_sums(const Requirement&, const OptionWeights&,
                                       const OptionChoice& reference);
  bool is_of_length(const Requirement&) const;
  std::size_t row_of(const Requirement&) const;
  std::size_t component(const Requirement&, std::size_t axis) const;
  const double* part(std::size_t coordinate, std::size_t column, ColumnPart);
  const double* squares_of_length(const Requirement&, std::size_t column);

  const Spec& spec_;
  const ErrorColumns& columns_;
  std::map<std::tuple<std::size_t, std::size_t, ColumnPart>, AlignedNumbers> parts_;
  std::map<std::pair<std::size_t, std::size_t>, AlignedNumbers> squares_of_lengths_;
  std::vector<AlignedNumbers> along_;  // components of lengths
};

/// What the search must know of closed loops and walls, as weighted sums over the encoders:
///
///     closed_torque, closed_position   sum ||G_e||_1 h_e, and sum ||G_e||_2^2 v_e, at each configuration
///     wall.NAME.stiffness              1/K = max(1/K_rate, sum max_i(|g_i|/(2 f_i)) |g^T C|_e Delta_e)
///     loop.JOINT.limit_cycle           ||L/(1 + L)||_1/2 sum |C_je| Delta_e, or wider with play
///     other figures of loops           no encoder changes them
///
/// A figure of a loop or a wall is a ratio that is 1 at the stated limit, and below it where the limit is
/// met.
class ControlSums {
 public:
  /// @param spec         with the filters and controllers of the search
  /// @param resolutions  [joint][option]: of its encoder
  ControlSums(const Spec& spec, std::size_t configurations, std::vector<std::vector<double>> resolutions);

  /// @pre r is of a loop, a wall, or a signal with norms of its own
  /// @returns a figure without sums where errors other than those of symmetric counts are in it: the report's
  /// own evaluation decides
  ChoiceFigure figure(const Requirement& r, const OptionWeights&);

 private:
  ChoiceFigure closed(const Requirement&, const OptionWeights&);
  ChoiceFigure wall(const Requirement&, std::size_t wall);
  ChoiceFigure limit_cycle(const Requirement&, const WorstLoop&);
  double* new_column();

  const Spec spec_;
  std::size_t configurations_;
  Eigen::MatrixXd drawn_;
  std::vector<std::vector<double>> widths_;  // [joint][option]: see widths_at_rest
  std::optional<ControlReport> report_;
  std::deque<AlignedNumbers> columns_;
};

/// The limit of a figure of a loop or a wall in terms of its ratio. @param limit  infinite: none
double ratio_limit(const Requirement&, double limit);

/// Refuses requirements of loops and walls that no search can limit.
/// @throws Error (input)
void require_limit_of_control(const Requirement&, const Spec&);

struct PricedOption {
  EncoderOption option;
  std::shared_ptr<const Spec> variant = nullptr;  ///< the base with it; null: too many to keep
  std::optional<double> price = 0.0;              ///< as in DesignedEncoder
  double bits = 0;
  std::int64_t cost = 0;  ///< what the search minimizes: millionths of the price, or of the bits
};

/// One choice for each filter and gain of the spec.
struct FilterSet {
  std::vector<NamedFilter> filters;
  std::vector<DesignedFilter> designed = {};  ///< those that are chosen
  std::vector<DesignedGain> gains = {};       ///< the same of gains
  std::shared_ptr<const Control> control =
      nullptr;  ///< with these filters and gains; null: the spec has none
  /// Results of choices that were evaluated: a search asks for the same ones at many limits.
  std::shared_ptr<std::map<OptionChoice, std::vector<RequirementResult>>> evaluated = nullptr;

  /// A spec with these filters and gains.
  Spec applied(Spec) const;
};

/// The choice of encoders of a spec as a ChoiceProblem, for any filters.
///
/// Figure i of the problem is requirement i of `base()`; those on filters and on count rates have no sums and
/// are not judged: options that do not meet the latter are left out.
class DesignProblem {
 public:
  /// @param more  entries of `figure_entry` to evaluate beside the requirements
  DesignProblem(const SpecVariants&, const DesignRequest&, const std::vector<Node>& more,
                const WorkspaceOptions&);
  DesignProblem(const DesignProblem&) = delete;
  DesignProblem& operator=(const DesignProblem&) = delete;

  /// The spec with the further entries among its requirements.
  const Spec& base() const { return base_; }
  /// Options of every independent joint by ascending cost; one, nameless and free, where none are stated.
  const std::vector<std::vector<PricedOption>>& options() const { return options_; }
  bool chosen(std::size_t joint) const {
    return options_[joint].empty() || !options_[joint].front().option.name.empty();
  }
  /// Whether costs are bits: the coarsest is looked for, or an option has no price.
  bool by_bits() const { return by_bits_; }

  /// Options that are no choice, since they cannot count as fast as their joint moves, in sentences.
  const std::vector<std::string>& left_out() const { return left_out_; }
  /// Joints without an option that can, in sentences; then `problem` must not be called.
  const std::vector<std::string>& obstacles() const { return obstacles_; }

  /// The base and its variants by one option, one of each kind of slow errors: their ratios of sigma behind a
  /// filter differ.
  const std::vector<std::pair<std::shared_ptr<const Spec>, std::size_t>>& with_slow_errors() const {
    return slow_;
  }

  /// The problem with these filters in place of the spec's. It borrows the columns of this object.
  ChoiceProblem problem(const FilterSet&);

  Spec variant(const OptionChoice&, const FilterSet&) const;
  std::vector<SpecChange> changes(const OptionChoice&) const;
  std::vector<Node> effects(const OptionChoice&) const;

  /// The requirements with a choice, as `check` evaluates them.
  /// @param limits  in place of those of the requirements; may be null
  std::vector<RequirementResult> results(const OptionChoice&, const FilterSet&,
                                         const std::vector<double>* limits = nullptr) const;

 private:
  void read_options(const DesignRequest&);
  void read_joint(const JointOptions&, bool kept, std::vector<Fault>&);
  void add_slow_errors(std::shared_ptr<const Spec>, std::size_t joint);
  Spec variant_by(std::size_t joint, std::size_t option) const;
  std::string too_fast(const Spec& variant, std::size_t joint) const;
  void leave_out(std::size_t joint, const std::vector<std::pair<std::string, std::string>>& options);
  Spec variant_of(const std::vector<SpecChange>&, const std::vector<Node>& effects) const;
  SpecChange change(std::size_t joint, std::size_t option) const;
  std::vector<Node> effects_of(std::size_t joint, std::size_t option) const;
  void make_columns();
  bool of_loops(const Requirement&) const;
  ControlSums* control_sums(const FilterSet&);
  OptionWeights weights_with(const std::vector<NamedFilter>&) const;
  ChoiceCut cut_at(const Eigen::VectorXd& q, std::size_t figure, const OptionWeights&, const OptionChoice&,
                   const ChoiceProblem& shape) const;

  const SpecVariants& variants_;
  WorkspaceOptions workspace_;
  std::vector<SpecChange> common_;
  Spec base_;
  bool needs_motion_noise_ = false, needs_rigorous_ = false, any_proven_ = false;
  std::vector<std::vector<PricedOption>> options_;
  std::vector<std::pair<std::shared_ptr<const Spec>, std::size_t>> slow_;  // and their joint
  bool by_bits_ = false;
  EncoderSpeeds speeds_;
  std::vector<std::string> left_out_, obstacles_;
  std::vector<IndependentError> sources_;  // places of all options' error sources
  std::unique_ptr<ErrorColumns> columns_;
  std::unique_ptr<FigureSums> sums_;
  std::vector<std::unique_ptr<ControlSums>> control_;  // one for each set of filters
  double kept_numbers_ = 0;                            // in it
};

/// A choice of encoders behind one of the filter sets.
struct FoundDesign {
  std::int64_t cost = 0;
  std::size_t set = 0;
  OptionChoice choice;
  bool operator==(const FoundDesign&) const = default;
};

/// What is looked for among the encoders and filter sets; limits by requirement of the problem's base.
using DesignQuery = SearchRequest<FoundDesign>;

/// Proven: no other design is cheaper, or has less of the goal.
struct DesignFindings : SearchResult<FoundDesign> {
  bool margin_proven = true;  ///< of those that cost as much, none has a better margin
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
