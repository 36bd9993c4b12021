#include "simulate/lane_kernels.hpp"

namespace qerr {

const SimulationKernels portable_simulation = lanes::simulation_kernels<2>;

}  // namespace qerr
