#pragma once

#include <cstdint>

#include "filter/norms/sequence.hpp"

namespace qerr {

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

}  // namespace qerr
