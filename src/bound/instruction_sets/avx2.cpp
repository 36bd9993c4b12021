#include "bound/lane_kernels.hpp"

namespace qerr {

const BoundKernels avx2_bounds = lanes::bound_kernels<4>;

}  // namespace qerr
