#pragma once

#include <vector>

#include "bound/bins.hpp"

namespace qerr {

/// Counts values >= 0 in bins 2^-10 of the value wide, over 64 octaves; memory does not grow with their
/// number.
///
/// Order statistics interpolate inside their bin: right to 1e-3 relative whatever the values are, and better
/// where they lie densely (some 1e-4 of 200 000 values, 1e-5 of millions). Values below 2^-40 of the typical
/// one count as the smallest, values above 2^24 of it as the largest (roll and yaw near the gimbal lock).
class Histogram {
 public:
  /// Bins that most values are expected in, by leading bits: where they are, counting is fast.
  struct Usual {
    std::int32_t first = 0, count = 0;
  };

  /// @param lowest   of `lowest_bin`
  /// @param counted  order statistics are known of values in these bins
  explicit Histogram(std::int32_t lowest, const CountedBins& counted = {}, const Usual& = {0, 0});

  const CountedBins& counted() const { return counted_; }

  /// The leading bits of the lowest bin, for values of the size that has these.
  static std::int32_t lowest_bin(std::int32_t typical);

  void add(double value);

  /// Values that were sorted out elsewhere: those in counted bins, by leading bits, and the number of others.
  void add(const std::int32_t* bins, std::size_t count, std::uint64_t below, std::uint64_t between);

  /// Adds what another one with the same bins has counted.
  void append(const Histogram&);

  /// Whether the value that has `rank` smaller ones before it lies in a counted bin.
  bool counts(std::uint64_t rank) const;

  /// The value that has `rank` smaller ones before it.
  /// @param min, max  of all values
  /// @pre counts(rank)
  double order_statistic(std::uint64_t rank, double min, double max) const;

 private:
  /// Of one bin. Neighbours among the values take different ones: a processor that reads a counter which it
  /// has just written waits.
  static constexpr std::size_t copies = 4;
  struct Counters {
    std::uint32_t in_turn[copies];
    std::uint64_t sum() const { return std::uint64_t{in_turn[0]} + in_turn[1] + in_turn[2] + in_turn[3]; }
  };
  std::uint64_t at(std::size_t bin) const;
  std::size_t index(std::int32_t leading) const;
  /// How many values lie in [begin, end) of the counted bins.
  std::uint64_t in_the_middle() const;
  void add_unusual(std::int32_t leading);
  void spill();

  std::int32_t lowest_;
  CountedBins counted_;
  Usual usual_;
  std::vector<Counters> few_;        // of the usual bins
  std::uint64_t added_ = 0;          // since the last spill: no counter can be larger
  std::vector<std::uint64_t> many_;  // of all bins, once it is needed
  std::uint64_t below_ = 0, between_ = 0;
};

}  // namespace qerr
