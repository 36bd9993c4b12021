#pragma once

#include <cstdlib>
#include <memory>
#include <vector>

#include "qerr/bound/bins.hpp"

namespace qerr {

/// Counts values >= 0 in bins 2^-10 of the value wide, over 64 octaves; memory does not grow with their
/// number.
///
/// Order statistics interpolate inside their bin: right to 1e-3 relative whatever the values are, and to some
/// 1e-5 where they lie densely. Values below 2^-40 of the typical one count as the smallest, values above
/// 2^24 of it as the largest (roll and yaw near the gimbal lock).
class Histogram {
 public:
  /// @param lowest  of `lowest_bin`
  explicit Histogram(std::int64_t lowest);

  /// The leading bits of the lowest bin, for values of this size.
  static std::int64_t lowest_bin(double typical);

  void add(const std::uint16_t* bins, std::size_t count);

  /// Where as many bins may be counted by hand, which are taken as counted; for as long as it lives.
  std::uint32_t* counts_for(std::size_t count);

  /// Adds what another one with the same lowest bin has counted.
  void append(const Histogram&);

  /// The value that has `rank` smaller ones before it. @param min, max  of all values
  double order_statistic(std::uint64_t rank, double min, double max) const;

 private:
  struct Free {
    void operator()(std::uint32_t* p) const { std::free(p); }
  };
  std::uint64_t at(std::size_t bin) const { return few_[bin] + (many_.empty() ? 0 : many_[bin]); }
  void spill();

  std::int64_t lowest_;
  std::unique_ptr<std::uint32_t[], Free> few_;  // pages that are never touched take no memory
  std::uint64_t added_ = 0;                     // since the last spill: no counter can be larger
  std::vector<std::uint64_t> many_;
};

}  // namespace qerr
