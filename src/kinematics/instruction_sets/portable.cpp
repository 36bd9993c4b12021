#include "kinematics/lane_kernels.hpp"

namespace qerr {

const KinematicKernels portable_kinematics = lanes::kinematic_kernels<2>;

}  // namespace qerr
