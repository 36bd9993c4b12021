#pragma once

#include <string>
#include <vector>

#include "diagnose/surrogates/surrogate.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// What the residual is projected on: orthonormal columns over the rows looked at, without their means.
struct Projection {
  std::string name;
  Eigen::ArrayXXd columns;  ///< rows x 1 or 2
  double to_counts = 1;     ///< from the projection to what is reported
};

/// A filter that the record can go through, and of how many rows it has forgotten where it began.
struct Velocity {
  std::string name;
  const Filter* filter;
  Eigen::Index settling;
  double h2;
};

/// What is the same for the record and for every surrogate.
struct ResidualPlan {
  const Evidence* e;
  std::vector<Stretch> parts;
  Eigen::Index rows = 0;  ///< of all parts
  std::vector<Projection> projections;
  std::vector<Velocity> velocities;
  Eigen::ArrayXd residual;  ///< of the record in these rows [counts]
  Eigen::ArrayXd state;     ///< its counts there, modulo four
  SurrogatePlan surrogates;
};

/// Which rows are looked at, and what their residuals are reduced to.
ResidualPlan residual_plan(const Evidence&, const std::vector<Filter>&, InstructionSet = instruction_set());

}  // namespace qerr
