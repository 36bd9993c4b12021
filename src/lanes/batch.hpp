#pragma once

#include <cstddef>

namespace qerr {

/// Number of configurations in one batch of the kernels. Batches are channel-major: the 64 numbers of one
/// joint, or of one figure, are contiguous, and all of a small arm fits in the first-level cache.
inline constexpr std::size_t batch_size = 64;

}  // namespace qerr
