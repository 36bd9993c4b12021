#include "../lane_residuals.hpp"

namespace qerr {

const ResidualKernels avx512_residuals = lanes::residual_kernels<8>;

}  // namespace qerr
