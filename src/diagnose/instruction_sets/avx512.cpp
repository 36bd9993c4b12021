#include "diagnose/surrogates/lane_residuals.hpp"
#include "diagnose/terms/lane_scan.hpp"

namespace qerr {

const ResidualKernels avx512_residuals = lanes::residual_kernels<8>;
const ScanKernels avx512_scan = lanes::scan_kernels<8>;

}  // namespace qerr
