#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "bound/kernels.hpp"
#include "qerr/bound/figure.hpp"

namespace qerr {

struct BoundKernels;

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

/// Statistic without `at_max`.
Statistic statistic(const JoinedTally&, const OrderStatistic&);

/// Order statistics at `percentile_ranks` of values that are not negative; infinite ones are the largest.
/// @param tally  of these values
OrderStatistic order_statistics(std::span<const double> values, const JoinedTally& tally);

/// The largest ones of many values: those above the least one that still counts, which rises.
class LargestValues {
 public:
  /// @param count   of values that are wanted, above 0
  /// @param sample  every nth one of the values, from which the least is estimated; may be empty
  LargestValues(std::size_t count, std::span<double> sample, std::size_t n);
  /// @param batch   batch_size values, of which the first `count` are added
  void add(const BoundKernels&, const double* batch, std::size_t count);
  /// Whether they are complete; else the sample was of other values, and they are added without it again.
  bool complete() const { return size_ >= count_; }
  /// Order statistics of the largest `count` ranks.
  OrderStatistic order_statistics() &&;

 private:
  std::size_t count_, size_ = 0;
  std::uint64_t added_ = 0;
  double least_ = -1;
  std::shared_ptr<double[]> kept_;
};

/// Counts values >= 0 in bins 2^-10 of the value wide, over 64 octaves; memory does not grow with their
/// number.
///
/// Order statistics interpolate within their bin: relative error at most 1e-3 for any values, less where they
/// are dense (about 1e-4 for 200 000 values, 1e-5 for millions). Values below 2^-40 times the typical one
/// count as the minimum, values above 2^24 times it as the maximum (roll and yaw near the gimbal lock).
class Histogram {
 public:
  /// Bins that most values are expected in, by leading bits; these are counted fast.
  struct Usual {
    std::int32_t first = 0, count = 0;
  };

  /// @param lowest   of `lowest_bin`
  /// @param counted  bins in which order statistics can be computed
  explicit Histogram(std::int32_t lowest, const CountedBins& counted = {}, const Usual& = {0, 0});

  const CountedBins& counted() const { return counted_; }

  /// Leading bits of the lowest bin for values of the size of a typical one, given by leading bits.
  static std::int32_t lowest_bin(std::int32_t typical);

  void add(double value);

  /// Adds values: the leading bits of those in counted bins, and the numbers of values below and between
  /// them.
  void add(const std::int32_t* bins, std::size_t count, std::uint64_t below, std::uint64_t between);

  /// Adds the counts of another histogram with the same bins.
  void append(const Histogram&);

  /// Whether the order statistic of a rank (0: the smallest value) lies in a counted bin.
  bool counts(std::uint64_t rank) const;

  /// Order statistic of a rank.
  /// @param min, max  of all values
  /// @pre counts(rank)
  double order_statistic(std::uint64_t rank, double min, double max) const;

 private:
  std::uint64_t count_of(std::size_t bin) const;
  std::size_t index(std::int32_t leading) const;
  /// Number of values in [begin, end) of the counted bins.
  std::uint64_t in_the_middle() const;
  void add_unusual(std::int32_t leading);

  std::int32_t lowest_;
  CountedBins counted_;
  Usual usual_;
  std::vector<std::uint64_t> few_;   // of the usual bins
  std::vector<std::uint64_t> many_;  // of all bins; allocated when needed
  std::uint64_t below_ = 0, between_ = 0;
};

}  // namespace qerr
