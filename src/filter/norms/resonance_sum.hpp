#pragma once

#include <cstdint>

#include "filter/norms/modes.hpp"

namespace qerr {

/// sum |2 Re(c z^k)| over from <= k < end for one pair of poles, proven, however many turns it takes: the
/// signs form a Sturmian word, whose sum a Euclidean recursion finds in the number of digits of `end`.
/// @pre mode.pair, mode.c has one element, 0 <= from < end <= 2^52
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end);

}  // namespace qerr
