#pragma once

#include <string>
#include <vector>

#include "diagnose/surrogates/surrogate.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Orthonormal columns without their means on which the residual is projected.
struct Projection {
  std::string name;
  Eigen::ArrayXXd columns;  ///< rows x 1 or 2
  double to_counts = 1;     ///< factor from the projection to the reported statistic
};

/// A derivative filter that is applied to the residual.
struct FilteredResidual {
  std::string name;
  const Filter* filter;   ///< must outlive the plan
  Eigen::Index settling;  ///< rows until the initial transient has decayed
  double h2;              ///< H2 norm
};

/// What the record and all surrogates have in common. The evidence and the filters must outlive it.
struct ResidualPlan {
  const Evidence* e;
  std::vector<RowRange> ranges;
  Eigen::Index rows = 0;  ///< of all ranges
  std::vector<Projection> projections;
  std::vector<FilteredResidual> velocities;
  Eigen::ArrayXd residual;  ///< of the record in these rows [counts]
  Eigen::ArrayXd state;     ///< counts of the record, modulo four
  SurrogatePlan surrogates;
};

/// Selects the rows that are evaluated and the statistics of their residuals.
ResidualPlan residual_plan(const Evidence&, const std::vector<Filter>&, InstructionSet = instruction_set());

}  // namespace qerr
