#include "kinematics/lane_kernels.hpp"

namespace qerr {

const KinematicKernels avx512_kinematics = lanes::kinematic_kernels<8>;

}  // namespace qerr
