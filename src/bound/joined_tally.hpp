#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bound/tally.hpp"
#include "qerr/bound/statistic.hpp"

namespace qerr {

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
