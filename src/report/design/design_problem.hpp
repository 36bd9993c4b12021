#pragma once

#include <map>
#include <memory>
#include <tuple>

#include "bound/error_columns.hpp"
#include "design/encoder_choice.hpp"
#include "input/design_request.hpp"
#include "input/spec_variants.hpp"
#include "qerr/report/design_report.hpp"

namespace qerr {

/// An option of a joint with its price.
struct PricedOption {
  EncoderOption option;
  double price = 0, bits = 0;  ///< as in DesignedEncoder
  std::int64_t cost = 0;       ///< what the search minimizes: millionths of the price, or of the bits
};

/// The choice of encoders of a spec as a ChoiceProblem, for any filters.
///
/// Figure i of the problem is requirement i of `base()`; requirements on filters alone have no sums and are
/// not judged.
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
  bool chosen(std::size_t joint) const { return !options_[joint].front().option.name.empty(); }

  /// The problem with these filters in place of the spec's. It borrows the columns of this object.
  ChoiceProblem problem(const std::vector<NamedFilter>& filters);

  /// The spec with a choice.
  Spec variant(const OptionChoice&, const std::vector<NamedFilter>& filters) const;
  std::vector<SpecChange> changes(const OptionChoice&) const;
  std::vector<Node> effects(const OptionChoice&) const;

  /// The requirements with a choice, as `check` evaluates them.
  std::vector<RequirementResult> results(const OptionChoice&, const std::vector<NamedFilter>& filters) const;

 private:
  enum class Part { magnitude, square, positive, negative };
  struct ColumnKey;

  void read_options(const DesignRequest&);
  Spec variant_of(const std::vector<SpecChange>&, const std::vector<Node>& effects) const;
  SpecChange change(std::size_t joint, std::size_t option) const;
  std::vector<Node> effects_of(std::size_t joint, std::size_t option) const;
  void make_columns();
  void weigh(const std::vector<NamedFilter>&);
  void find_owners();
  ChoiceFigure figure(const Requirement&);
  WeightedSum sigma_sum(const Requirement&);
  std::vector<WeightedSum> worst_sums(const Requirement&, std::size_t coordinate);
  template <class Weight>
  void add_column(WeightedSum&, std::size_t column, const double* coefficients, Weight);
  const double* part(std::size_t coordinate, std::size_t column, Part);
  const double* squares_of_length(std::size_t first, std::size_t column);

  const SpecVariants& variants_;
  WorkspaceOptions workspace_;
  std::vector<SpecChange> common_;
  Spec base_;
  bool needs_motion_noise_ = false, needs_rigorous_ = false;
  std::vector<std::vector<PricedOption>> options_;
  std::unique_ptr<ErrorColumns> columns_;
  std::map<std::tuple<std::size_t, std::size_t, Part>, AlignedNumbers> parts_;
  std::vector<std::vector<ErrorWeights>> weights_;  // [joint][option]
  std::vector<std::size_t> owners_;                 // [column]
  bool biased_ = false;
};

}  // namespace qerr
