#pragma once

#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"

namespace qerr {

/// sum |x_k| over k >= from, proven: between `sum` - `error` and `sum` + `error` + `beyond`.
struct TailSum {
  RealBall sum;
  double error = 0;
  double beyond = 0;  ///< upper bound of what was not summed
};

/// The part of an impulse response that a sum of modes is, from a sample on to infinity.
///
/// By runs of one sign (`sum_of_runs`), from which a mode is left out as soon as what it still adds is
/// negligible: so a resonance that outlives the others by far ends alone, and its turns, however many, are
/// summed by `resonance_sum`. Where there would be too many runs, the rest is only bounded.
/// @param scale  a lower bound of the whole norm, against which parts can be negligible
/// @param work  blocks that may be looked at, times modes
TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work);

/// The first sample, at most `latest`, from which all modes but the longest-lived one are negligible.
std::int64_t slowest_alone_from(const std::vector<Mode>& modes, std::int64_t from, std::int64_t latest,
                                double scale);

}  // namespace qerr
