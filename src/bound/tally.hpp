#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

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
