#include "bound/kernels.hpp"

namespace qerr {

const BoundKernels& bound_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512_bounds;
  if (set == InstructionSet::avx2) return avx2_bounds;
#endif
  static_cast<void>(set);
  return portable_bounds;
}

}  // namespace qerr
