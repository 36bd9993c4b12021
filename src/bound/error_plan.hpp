#pragma once

#include <vector>

#include "bound/batched_error.hpp"
#include "bound/kernels.hpp"
#include "kinematics/folded_chain.hpp"

namespace qerr {

/// Builds an ErrorPlan from a model and owns the arrays that it points to.
class PlannedError {
 public:
  PlannedError(const OperationalModel&, const ErrorFigures&);
  PlannedError(const PlannedError&) = delete;
  PlannedError& operator=(const PlannedError&) = delete;

  const ErrorPlan& plan() const { return plan_; }

 private:
  void set_coordinates(const OperationalModel&);
  void add_errors(const OperationalModel&);
  /// @param scale  of which the part's sizes are multiples
  void add_error(const OperationalModel&, const IndependentError&, bool source, double scale);
  void set_direct();
  void share_scale();
  void set_remainder(const OperationalModel&);
  void set_filters(const OperationalModel&, const ErrorFigures&);
  void set_layout(const ErrorFigures&, std::size_t others);

  ErrorPlan plan_ = {};
  FoldedChain chain_;
  std::vector<double> column_scale_, per_column_, arm_, l1_, dc_gain_, ratio_squares_, motion_squares_;
  std::vector<int> coordinate_;
  std::vector<ErrorPart> parts_;
  std::vector<std::vector<JointWeight>> weights_;  // [part]
};

}  // namespace qerr
