#pragma once

#include <cstdint>
#include <set>

namespace qerr {

/// The grid of counts that are not all whole: the multiples of 1/denominator, as of an interpolated encoder
/// whose reading is written in counts before interpolation.
class CountGrid {
 public:
  /// @returns false if the values so far have more fractional parts than any grid
  bool add(double value);

  /// The least denominator, up to 1024, that serves all values; 0 if there is none.
  /// @param decimals  to which the values are rounded
  int denominator(int decimals) const;

 private:
  std::set<std::int64_t> parts_;  // distinct fractional parts, in units of 2^-30
  double largest_ = 0;
};

}  // namespace qerr
