#include "bound/lane_kernels.hpp"

namespace qerr {

const BoundKernels portable_bounds = lanes::bound_kernels<2>;

}  // namespace qerr
