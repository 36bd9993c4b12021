#include "simulate/lane_kernels.hpp"

namespace qerr {

const SimulationKernels avx512_simulation = lanes::simulation_kernels<8>;

}  // namespace qerr
