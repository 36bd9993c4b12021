// Compiled once per instruction set, with QERR_LANES doubles to a vector and the set's own flags.

#include <array>
#include <cstdint>

namespace qerr::bench {

/// As many independent chains as latency times throughput asks for (a multiplication and an addition apart
/// take 6 cycles at two a cycle), with their two constants still in sixteen registers.
inline constexpr int chains = 12;

/// Runs x <- a x + b `rounds` times in every chain.
double QERR_CHAINS(std::uint64_t rounds) {
  using Vector [[gnu::vector_size(8 * QERR_LANES)]] = double;
  Vector x[chains], a{}, b{};
  a += 0.999999, b += 1e-6;
  for (int k = 0; k < chains; ++k) x[k] = a + static_cast<double>(k);
  for (std::uint64_t i = 0; i < rounds; ++i) {
#pragma GCC unroll 12
    for (int k = 0; k < chains; ++k) x[k] = x[k] * a + b;
  }
  double sum = 0;
  for (const Vector& chain : x)
    for (int lane = 0; lane < QERR_LANES; ++lane) sum += chain[lane];
  return sum;
}

}  // namespace qerr::bench
