#include "diagnose/terms/scan_kernels.hpp"

namespace qerr {

const ScanKernels& scan_kernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return avx512_scan;
  if (set == InstructionSet::avx2) return avx2_scan;
#endif
  static_cast<void>(set);
  return portable_scan;
}

}  // namespace qerr
