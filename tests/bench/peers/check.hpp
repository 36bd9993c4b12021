#pragma once

#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Largest deviations of a contestant from the reference, relative to the largest figure of the same unit
/// (rows of positions or of rotations) over all configurations, where this is no less than 1e-4 of the
/// others: a tip on its only axis has no lever but rounding. NaN where the contestant does not show that
/// figure.
struct Deviation {
  double jacobian = 0, worst_case = 0, covariance = 0;
  double summary = 0;   ///< of maxima and means, and of the figure at the place of the maximum
  double quantile = 0;  ///< of quantiles, which come from histograms

  static constexpr double largest_allowed = 1e-12;
  static constexpr double largest_summary_allowed = 4e-12;  ///< 20 000 additions, each rounded by 2^-53
  static constexpr double largest_quantile_allowed = 0.01;
  bool agrees() const;
};

/// Lets contestant and reference do the same `count` configurations in every stage that both do.
Deviation deviation(const Contestant&, const Contestant& reference, const Problem&, std::uint64_t count);

}  // namespace qerr::bench
