#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "qerr/bound/tally.hpp"

namespace qerr {

/// How a quantity is distributed over the configurations. Percentiles interpolate linearly between order
/// statistics.
struct Statistic {
  double min = 0, mean = 0, max = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the first configuration that has the maximum, independent joints [rad or m]
};

/// Up to so many values percentiles are exact; beyond they are read off a histogram (histogram.hpp).
inline constexpr std::uint64_t exact_percentiles_limit = std::uint64_t{1} << 17;

/// Tallies of blocks of configurations, joined in their order.
class JoinedTally {
 public:
  void append(const Tally&, std::uint64_t count);

  double min() const { return count_ > 0 ? min_ : 0; }
  double max() const { return count_ > 0 ? max_ : 0; }
  double mean() const;
  std::uint64_t at_max() const { return at_max_; }
  std::uint64_t count() const { return count_; }

 private:
  double min_ = Tally::infinite, max_ = -1;
  std::uint64_t at_max_ = 0;
  long double sum_ = 0;
  std::uint64_t count_ = 0;
};

/// A few values into a tally, as the batched kernel adds 64.
void tally_some(const double* values, std::size_t count, std::uint64_t first, Tally&);

/// The order statistics that percentiles of so many values are made of.
std::vector<std::uint64_t> percentile_ranks(std::uint64_t count);

/// The value that has `rank` smaller ones before it.
using OrderStatistic = std::function<double(std::uint64_t rank)>;

/// Statistic without `at_max`; the order statistics are asked for from the largest percentile down.
Statistic statistic(const JoinedTally&, const OrderStatistic&);

/// Order statistics of these values, which get into another order; each rank is at most one more than the one
/// before.
OrderStatistic order_statistics(double* values, std::uint64_t count);

}  // namespace qerr
