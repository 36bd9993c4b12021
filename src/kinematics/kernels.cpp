#include "kinematics/kernels.hpp"

namespace qerr {

const KinematicKernels& kinematic_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512_kinematics;
  if (set == InstructionSet::avx2) return avx2_kinematics;
#endif
  static_cast<void>(set);
  return portable_kinematics;
}

}  // namespace qerr
