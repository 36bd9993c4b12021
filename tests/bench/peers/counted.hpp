#pragma once

#include "bound/kernels.hpp"

namespace qerr::bench {

/// Multiplications of one configuration in `jacobians` (scale: one number for each moving joint) and in
/// `errors`, fused ones and others, per lane. Compiled for processors with fused multiply-adds, hence without
/// Eigen.
double multiplications(const FoldedPath&, const double* scale, const double* q, double* room);
double multiplications(const ErrorPlan&, const double* q, double* figures, double* sums, double* room);

}  // namespace qerr::bench
