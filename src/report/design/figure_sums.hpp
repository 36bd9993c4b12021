#pragma once

#include <deque>
#include <map>
#include <tuple>

#include "bound/error_columns.hpp"
#include "design/choice_figure.hpp"
#include "qerr/input/spec.hpp"
#include "report/analysis/control.hpp"

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

}  // namespace qerr
