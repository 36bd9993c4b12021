#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace qerr {

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
