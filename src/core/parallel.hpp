#pragma once

#include <cstddef>
#include <functional>

namespace qerr {

/// Number of threads: the requested one, or one per core for 0.
unsigned thread_count(unsigned requested);

/// Runs `task(i)` for i in [0, count) on up to `threads` threads (0: one per core).
///
/// The assignment of tasks to threads is unspecified. A task writes only to its own result, and the caller
/// combines results in the order of i, so that they do not depend on the number of threads. The first
/// exception is rethrown.
/// Where the system permits fewer threads, these do all the work, and threads_refused() tells so from then
/// on.
void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task);

/// Whether the system has refused this process a thread.
bool threads_refused();

}  // namespace qerr
