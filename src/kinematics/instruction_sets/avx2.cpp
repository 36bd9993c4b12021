#include "kinematics/lane_kernels.hpp"

namespace qerr {

const KinematicKernels avx2_kinematics = lanes::kinematic_kernels<4>;

}  // namespace qerr
