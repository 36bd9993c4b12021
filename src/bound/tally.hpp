#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

/// Maxima within this factor are the same but for rounding: the first configuration has it.
inline constexpr double same_maximum = 1 + 1e-13;

/// What is known of one figure after some configurations. Plain, and aligned for the batched kernels.
struct alignas(64) Tally {
  static constexpr double infinite = __builtin_inf();
  double sum[8] = {};  ///< by lane, as `min`
  double min[8] = {infinite, infinite, infinite, infinite, infinite, infinite, infinite, infinite};
  double max = -1;  ///< or what it had to exceed from the start
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  std::uint64_t at_max = none;  ///< index of the first configuration with it
};

}  // namespace qerr
