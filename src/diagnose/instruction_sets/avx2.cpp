#include "diagnose/surrogates/lane_residuals.hpp"
#include "diagnose/terms/lane_scan.hpp"

namespace qerr {

const ResidualKernels avx2_residuals = lanes::residual_kernels<4>;
const ScanKernels avx2_scan = lanes::scan_kernels<4>;

}  // namespace qerr
