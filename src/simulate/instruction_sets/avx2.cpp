#include "simulate/lane_kernels.hpp"

namespace qerr {

const SimulationKernels avx2_simulation = lanes::simulation_kernels<4>;

}  // namespace qerr
