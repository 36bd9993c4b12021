#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

/// Bins of the histograms over configurations: the leading bits of a double, so that a bin's width is 2^-10
/// of the value. Plain, for the batched kernels.
inline constexpr int bin_shift = 42;
inline constexpr std::size_t bin_count = std::size_t{1} << 16;  ///< 64 octaves

/// The bin of a value >= 0 among those of all octaves.
inline std::int32_t leading_bits(double value) {
  return static_cast<std::int32_t>(__builtin_bit_cast(std::int64_t, value) >> bin_shift);
}

/// Which bins of a figure are counted one by one: [begin, end), and from `top` on. Of the values in others it
/// is only known how many lie below, and how many between. All by leading bits.
struct CountedBins {
  static constexpr std::int32_t first = -(1 << (63 - bin_shift));  ///< of all doubles
  std::int32_t begin = first, end = first, top = first;            ///< so: all bins

  bool operator()(std::int32_t bin) const { return (bin >= begin && bin < end) || bin >= top; }
};

}  // namespace qerr
