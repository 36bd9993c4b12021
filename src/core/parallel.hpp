#pragma once

#include <cstddef>
#include <functional>

namespace qerr {

/// Threads to work with: those asked for, or one per core (0).
unsigned thread_count(unsigned asked);

/// Runs `task(i)` for i in [0, count) on up to `threads` threads (0: one per core).
///
/// Which thread runs which task is not defined: a task writes only to its own place, and the caller joins the
/// places in the order of i, so that results do not depend on the number of threads. The first exception is
/// rethrown.
void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task);

}  // namespace qerr
