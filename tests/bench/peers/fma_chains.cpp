// Compiled once per instruction set, with QERR_LANES doubles per vector and the flags of the set.

#include <array>
#include <cstdint>

namespace qerr::bench {

/// Number of independent chains: at least latency times throughput (a multiplication and a separate addition
/// take 6 cycles at two per cycle), and at most what sixteen registers hold together with two constants.
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
