#pragma once

#include <vector>

#include "contestant.hpp"

namespace qerr::bench {

/// Largest deviations of a contestant from the reference, relative to the largest figure of the same unit
/// (rows of positions or of rotations) over all configurations, if this is at least 1e-4 of the others: for
/// a tip on its only axis, positions are rounding errors. NaN if the contestant does not output that figure.
struct Deviation {
  double jacobian = 0, worst_case = 0, covariance = 0;
  double summary = 0;   ///< of maxima and means, and of the figure at the configuration of the maximum
  double quantile = 0;  ///< of quantiles, which come from histograms

  static constexpr double largest_allowed = 1e-12;
  static constexpr double largest_summary_allowed = 4e-12;  ///< 20 000 additions, each rounded by 2^-53
  static constexpr double largest_quantile_allowed = 0.01;
  bool agrees() const;
};

/// Compares contestant and reference over the same `count` configurations in every stage that both support.
Deviation deviation(const Contestant&, const Contestant& reference, const Problem&, std::uint64_t count);

}  // namespace qerr::bench
