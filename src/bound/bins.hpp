#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

/// Histogram bins: the leading bits of a double (exponent and 10 bits of the mantissa), so that a bin's width
/// is about 2^-10 of the value. Without containers, for the batched kernels.
inline constexpr int bin_shift = 42;
inline constexpr std::size_t bin_count = std::size_t{1} << 16;  ///< 64 octaves

/// The bin of a value >= 0.
inline std::int32_t leading_bits(double value) {
  return static_cast<std::int32_t>(__builtin_bit_cast(std::int64_t, value) >> bin_shift);
}

/// Bins of a figure that are counted individually, by leading bits: [begin, end) and [top, infinity). Values
/// below `begin` and values in [end, top) are only counted in total.
struct CountedBins {
  static constexpr std::int32_t first = -(1 << (63 - bin_shift));  ///< below all doubles
  std::int32_t begin = first, end = first, top = first;            ///< default: all bins

  bool operator()(std::int32_t bin) const { return (bin >= begin && bin < end) || bin >= top; }
};

}  // namespace qerr
