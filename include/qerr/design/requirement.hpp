#pragma once

#include <cstddef>
#include <string>

#include "qerr/bound/workspace.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

/// `requirements:` of a spec: a statistic of a bound must not exceed a figure.
struct Requirement {
  enum class Bound { worst_case, worst_case_rigorous, sigma, sigma_in_motion };

  std::string quantity;        ///< as written: `velocity.x.sigma`
  std::string statistic;       ///< as written: `p99`
  std::size_t coordinate = 0;  ///< index into the model's coordinates
  std::ptrdiff_t filter = -1;  ///< index into the filters; -1: the position itself
  Bound bound = Bound::sigma;
  double Statistic::*value = &Statistic::max;  ///< of the statistic
  double at_most = 0;                          ///< SI
  std::string unit;
  Place place;
};

/// A requirement held against the figures.
struct RequirementResult {
  double value = 0;  ///< +inf where the quantity has no bound
  bool met = false;  ///< value <= at_most
};

RequirementResult evaluate(const Requirement&, const Workspace&);

}  // namespace qerr
