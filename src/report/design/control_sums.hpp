#pragma once

#include <deque>

#include "report/analysis/control.hpp"
#include "report/design/figure_sums.hpp"

namespace qerr {

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
