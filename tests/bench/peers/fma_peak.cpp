#include "fma_peak.hpp"

namespace qerr::bench {

double fma_chains_portable(std::uint64_t rounds);
double fma_chains_avx2(std::uint64_t rounds);
double fma_chains_avx512(std::uint64_t rounds);

std::vector<FmaPeak> fma_peaks() {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512dq");
  return {{"portable", 2, "mulpd + addpd", true, fma_chains_portable},
          {"avx2", 4, "vfmadd ymm", avx2, fma_chains_avx2},
          {"avx512", 8, "vfmadd zmm", avx512, fma_chains_avx512}};
#else
  return {{"portable", 2, "multiply-add", true, fma_chains_portable}};
#endif
}

}  // namespace qerr::bench
