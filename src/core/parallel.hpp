#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

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

/// Computes texts in parallel and passes them on in their order, each as soon as those before it have been.
///
/// At most a few texts for each thread are held, so that memory is bounded. The first exception of either
/// function ends the work and is rethrown, after the texts before it, if `make` threw it, have been passed
/// on.
/// @param make  the text of i in [0, count); called on any thread
/// @param pass  called with one text after the other, by one thread at a time
void texts_in_order(std::uint64_t count, unsigned threads,
                    const std::function<std::string(std::uint64_t)>& make,
                    const std::function<void(std::uint64_t, std::string)>& pass);

}  // namespace qerr
