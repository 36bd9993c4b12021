#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>

namespace qerr {

/// Distribution of a quantity over the configurations. Percentiles interpolate linearly between order
/// statistics.
struct Statistic {
  double min = 0, mean = 0, max = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the first configuration that has the maximum, independent joints [rad or m]
};

/// A member of Statistic. A new one is a member there and a row in the list of statistic.cpp.
struct StatisticKind {
  std::string_view name;     ///< in specs and reports
  std::string_view heading;  ///< of its column in tables; empty: in JSON and CSV only
  std::string_view summary;
  double Statistic::*value;
  double percentile = -1;  ///< fraction of the values below it; negative: not a percentile
};

/// The statistic that is a bound of the maximum over the whole joint ranges (proven_maximum.hpp) in place of
/// one over the configurations: no member of Statistic.
inline constexpr std::string_view proven_statistic = "proven_max";

/// All of them, in the order of the reports.
std::span<const StatisticKind> statistic_kinds();

/// The kind of a name; null: unknown.
const StatisticKind* find_statistic(std::string_view name);

/// Statistics of the quantity times a factor >= 0.
Statistic scaled(const Statistic&, double factor);

/// Up to this many values percentiles are exact; beyond they are read off a histogram (histogram.hpp).
inline constexpr std::uint64_t exact_percentiles_limit = std::uint64_t{1} << 17;

}  // namespace qerr
