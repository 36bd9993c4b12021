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

/// Maxima within this factor are equal up to rounding; the first configuration is reported.
inline constexpr double same_maximum = 1 + 1e-13;

/// Sum, minimum and maximum of one figure over some configurations. Without containers, and aligned, for the
/// batched kernels.
struct alignas(64) Tally {
  static constexpr double infinite = __builtin_inf();
  double sum[8] = {};  ///< [lane], as `min`
  double min[8] = {infinite, infinite, infinite, infinite, infinite, infinite, infinite, infinite};
  double max = -1;  ///< or the value that it had to exceed
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  std::uint64_t at_max = none;  ///< index of the first configuration with it
};

}  // namespace qerr
