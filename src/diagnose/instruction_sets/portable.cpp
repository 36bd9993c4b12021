#include "../lane_residuals.hpp"

namespace qerr {

const ResidualKernels portable_residuals = lanes::residual_kernels<2>;

}  // namespace qerr
