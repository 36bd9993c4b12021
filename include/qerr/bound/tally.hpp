#pragma once

#include <cstddef>
#include <cstdint>

namespace qerr {

/// Maxima within this factor are the same but for rounding: the first configuration has it.
inline constexpr double same_maximum = 1 + 1e-13;

/// What is known of one figure after some configurations. Plain, for the batched kernels.
struct Tally {
  double sum[8] = {};  ///< by lane
  double min = __builtin_inf(), max = -1;
  std::uint64_t at_max = 0;  ///< index of the first configuration with it
};

}  // namespace qerr
