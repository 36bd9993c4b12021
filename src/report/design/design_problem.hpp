#pragma once

#include <memory>

#include "design/encoder_choice.hpp"
#include "input/design_request.hpp"
#include "input/spec_variants.hpp"
#include "qerr/report/design_report.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/design/figure_sums.hpp"

namespace qerr {

/// An option of a joint with its price.
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

  /// The spec with a choice.
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

}  // namespace qerr
