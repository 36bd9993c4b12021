#include "diagnose/surrogates/lane_residuals.hpp"
#include "diagnose/terms/lane_scan.hpp"

namespace qerr {

const ResidualKernels portable_residuals = lanes::residual_kernels<2>;
const ScanKernels portable_scan = lanes::scan_kernels<2>;

}  // namespace qerr
