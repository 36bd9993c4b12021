#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bound/tally.hpp"
#include "qerr/bound/figure.hpp"

namespace qerr {

/// Sum of the tallies of blocks of configurations, appended in their order.
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

/// Adds `count` values to a tally, as the batched kernel adds 64.
void tally_some(const double* values, std::size_t count, std::uint64_t first, Tally&);

/// Ranks of the order statistics from which the percentiles of `count` values are interpolated.
std::vector<std::uint64_t> percentile_ranks(std::uint64_t count);

/// The value of a rank; 0: the smallest.
using OrderStatistic = std::function<double(std::uint64_t rank)>;

/// Ranks from which one percentile is interpolated, and its value.
std::vector<std::uint64_t> percentile_ranks(double fraction, std::uint64_t count);
double percentile(double fraction, std::uint64_t count, const OrderStatistic&);

/// Statistic without `at_max`. Ranks are requested in descending order.
Statistic statistic(const JoinedTally&, const OrderStatistic&);

/// Order statistics of values, which are reordered.
/// @pre ranks are requested in descending order, but for one more than the previous rank
OrderStatistic order_statistics(double* values, std::uint64_t count);

}  // namespace qerr
