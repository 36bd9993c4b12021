#pragma once

#include <cstddef>

namespace qerr {

/// How many configurations the batched kernels take at once. Channel-major: the 64 numbers of one joint, or
/// of one figure, stand side by side, and all of a small arm stays in the first-level cache.
inline constexpr std::size_t batch_size = 64;

}  // namespace qerr
