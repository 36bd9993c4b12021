#pragma once

#include <cstdint>

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

}  // namespace qerr
