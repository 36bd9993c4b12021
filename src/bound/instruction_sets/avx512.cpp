#include "bound/lane_kernels.hpp"

namespace qerr {

const BoundKernels avx512_bounds = lanes::bound_kernels<8>;

}  // namespace qerr
