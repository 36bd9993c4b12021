#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

/// Bins of the histograms over configurations: the leading bits of a double, so that a bin's width is 2^-10
/// of the value. Plain, for the batched kernels.
inline constexpr int bin_shift = 42;
inline constexpr std::size_t bin_count = std::size_t{1} << 16;  ///< 64 octaves
inline constexpr std::int64_t last_bin = bin_count - 1;

/// The bin of a value >= 0, given the leading bits of the lowest bin.
inline std::uint16_t bin_of(double value, std::int64_t lowest) {
  const std::int64_t bin = (__builtin_bit_cast(std::int64_t, value) >> bin_shift) - lowest;
  return static_cast<std::uint16_t>(bin < 0 ? 0 : bin > last_bin ? last_bin : bin);
}

}  // namespace qerr
