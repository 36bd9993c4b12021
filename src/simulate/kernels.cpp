#include "simulate/kernels.hpp"

namespace qerr {

const SimulationKernels& simulation_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512_simulation;
  if (set == InstructionSet::avx2) return avx2_simulation;
#endif
  static_cast<void>(set);
  return portable_simulation;
}

}  // namespace qerr
