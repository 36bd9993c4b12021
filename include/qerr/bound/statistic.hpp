#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace qerr {

/// How a quantity is distributed over the configurations. Percentiles interpolate linearly between order
/// statistics.
struct Statistic {
  double min = 0, mean = 0, max = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the first configuration that has the maximum, independent joints [rad or m]
};

/// Up to so many values percentiles are exact; beyond they are read off a histogram (histogram.hpp).
inline constexpr std::uint64_t exact_percentiles_limit = std::uint64_t{1} << 17;

}  // namespace qerr
