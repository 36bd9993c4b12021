#include "../lane_residuals.hpp"

namespace qerr {

const ResidualKernels avx2_residuals = lanes::residual_kernels<4>;

}  // namespace qerr
