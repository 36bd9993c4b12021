#pragma once

#include <cstdint>
#include <vector>

#include "bound/histogram.hpp"

namespace qerr {

/// Bins of a sample of values in their order, as leading bits: what a histogram of many more can expect.
class SampledBins {
 public:
  /// @pre begin < end
  SampledBins(const std::int32_t* begin, const std::int32_t* end);

  /// That of the value with `rank` smaller ones before it; what is 64 octaves below the largest, or not
  /// finite, as the nearest bin beyond the others.
  std::int32_t operator[](std::uint64_t rank) const;

  /// The bins that percentiles of all values need: some standard deviations on either side of the median, and
  /// from as far below the next percentile on. Where the values are independent, three of a million such
  /// edges are on the wrong side.
  CountedBins near_percentiles() const;

  /// From the smallest to an octave above the largest.
  Histogram::Usual usual() const;

 private:
  std::uint64_t count_;
  std::int32_t first_;
  std::vector<std::uint32_t> counts_;
};

}  // namespace qerr
