#pragma once

#include <cstddef>
#include <string>

#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

/// An entry of `requirements:` in a spec: the upper limit of a statistic of a bound.
struct Requirement {
  enum class Bound { worst_case, worst_case_rigorous, sigma, sigma_in_motion };

  std::string quantity;        ///< as in the spec: `velocity.x.sigma`
  std::string statistic;       ///< as in the spec: `p99`
  std::size_t coordinate = 0;  ///< index into the coordinates of the model
  std::ptrdiff_t filter = -1;  ///< index into the filters; -1: the unfiltered position
  Bound bound = Bound::sigma;
  double Statistic::*value = &Statistic::max;  ///< member of Statistic for `statistic`
  double at_most = 0;                          ///< limit in `unit` [SI]
  std::string unit;
  Place place;
};

/// Evaluation of a requirement.
struct RequirementResult {
  double value = 0;  ///< +inf if the quantity is unbounded
  bool met = false;  ///< value <= at_most
};

/// Compares a statistic over the configurations with the limit.
/// @throws Error (input) if sigma in motion is required but not computed
RequirementResult evaluate(const Requirement&, const Workspace&);

}  // namespace qerr
