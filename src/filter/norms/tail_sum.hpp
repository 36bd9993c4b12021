#pragma once

#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"
#include "filter/norms/sequence.hpp"

namespace qerr {

/// sum |x_k| over first..next-1, within `error` of `sum`.
struct RunsSum {
  RealBall sum;
  double error = 0;
  std::int64_t next = 0;
  std::int64_t visits = 0;  ///< remaining of the given ones
};

/// Sums |x_k| over first..end-1 by its runs of one sign, each a difference of two values of the sum of x: the
/// work grows with the number of sign changes and not with the length. Stops early after `visits` blocks.
/// @param powers  of the modes of x
/// @param scale  lower bound of the norm: blocks are negligible relative to it
/// @pre x.accurate()
RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits);

/// Relative error of a sampled sum against the sum of the sizes of all modes.
inline constexpr double sampling_error = 1.5e-14;

/// sum |x_k| over first..end-1 of simple modes, sample by sample in doubles, within `error` of `sum`: about 1
/// ns a sample and mode.
struct SampledSum {
  double sum = 0;
  double error = 0;
};

SampledSum sampled_sum(const std::vector<Mode>& modes, const Powers& powers, std::int64_t first,
                       std::int64_t end);

/// sum |2 Re(c z^k)| over from <= k < end for a simple conjugate pair of poles, proven.
///
/// The signs of the terms form a Sturmian word, which Euclid's algorithm sums in O(log(end)) steps, however
/// many periods of the resonance there are.
/// @pre mode.pair, mode.c has one element, 0 <= from < end <= 2^52
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end);

/// Enclosure of sum |x_k| over k >= from: `sum` - `error` to `sum` + `error` + `beyond`.
struct TailSum {
  RealBall sum;
  double error = 0;
  double beyond = 0;  ///< upper bound of the terms that were not summed
};

/// The enclosure of the sum over both ranges.
TailSum operator+(TailSum, const TailSum&);

/// Sums a modal expansion of an impulse response from a sample to infinity.
///
/// By runs of one sign (`sum_of_runs`), or sample by sample where these are few (`sampled_sum`). A mode is
/// dropped when its remaining sum is negligible; a resonance that decays much more slowly than the others
/// finally remains alone and is summed by `resonance_sum`. What exceeds the limit of work is only bounded.
/// @param scale  lower bound of the norm: parts are negligible relative to it
/// @param work  limit of blocks of sign runs times modes
TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work);

/// The step for which every step-th sample, for each of the `step` first samples a sequence of its own, has
/// the fewest changes of sign: 2 for poles near z = -1 beside others near 1, n for poles near the n-th roots
/// of 1. 1 where no step up to 240 is better.
std::int64_t decimation(const std::vector<Mode>& modes, std::int64_t from, double scale);

}  // namespace qerr
