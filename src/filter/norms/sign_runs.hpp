#pragma once

#include <cstdint>

#include "filter/norms/sequence.hpp"

namespace qerr {

/// sum |x_k| over a stretch, proven: `sum` holds it but for `error` (which can only make it larger or smaller
/// by so much), up to and without `next`.
struct RunsSum {
  RealBall sum;
  double error = 0;
  std::int64_t next = 0;
  std::int64_t visits = 0;  ///< what is left of them
};

/// Sums |x_k| over first..end-1 by its runs of one sign, each a difference of the sum of x: work grows with
/// the number of sign changes and not with the length. Stops early when `visits` blocks were looked at.
/// @param powers  of the modes of x
/// @param scale  a lower bound of the whole norm, against which a block can be negligible
/// @pre x.trusted()
RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits);

}  // namespace qerr
