#include "diagnose/surrogates/residual_kernels.hpp"

namespace qerr {

const ResidualKernels& residual_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512_residuals;
  if (set == InstructionSet::avx2) return avx2_residuals;
#endif
  static_cast<void>(set);
  return portable_residuals;
}

}  // namespace qerr
