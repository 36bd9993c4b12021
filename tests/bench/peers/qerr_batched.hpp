#pragma once

#include "contestant.hpp"

namespace qerr::bench {

/// The batched kernels on every instruction set that this processor has: Sampler and BatchedJacobian (jac),
/// Sampler and BatchedError (job), workspace() with worst case and sigma alone (full).
std::vector<Contestant> qerr_batched();

/// Operations of one configuration that need the FMA pipes: fused multiply-adds and multiplications, counted
/// by running the same kernels with a counting number type.
double counted_operations(const Problem&, Stage);

}  // namespace qerr::bench
