#pragma once

#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Largest deviations of a contestant from the reference, relative to the largest figure of the same unit
/// (rows of positions or of rotations) over all configurations; NaN where it does not show that figure.
struct Deviation {
  double jacobian = 0, worst_case = 0, covariance = 0;
  double summary = 0;   ///< of maxima and means, and of the figure at the place of the maximum
  double quantile = 0;  ///< of quantiles, which come from histograms

  static constexpr double largest_allowed = 1e-12, largest_quantile_allowed = 0.01;
  bool agrees() const;
};

/// Lets contestant and reference do the same `count` configurations in every stage that both do.
Deviation deviation(const Contestant&, const Contestant& reference, const Problem&, std::uint64_t count);

}  // namespace qerr::bench
