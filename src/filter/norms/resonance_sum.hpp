#pragma once

#include <cstdint>

#include "filter/norms/modes.hpp"

namespace qerr {

/// sum |2 Re(c z^k)| over from <= k < end for a simple conjugate pair of poles, proven.
///
/// The signs of the terms form a Sturmian word, which Euclid's algorithm sums in O(log(end)) steps, however
/// many periods of the resonance there are.
/// @pre mode.pair, mode.c has one element, 0 <= from < end <= 2^52
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end);

}  // namespace qerr
