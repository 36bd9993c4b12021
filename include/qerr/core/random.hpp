#pragma once

#include <cstdint>

namespace qerr {

/// Counter-based random numbers: the value depends on (seed, index, stream) alone, never on how many were
/// drawn before, on threads, or on the standard library.
///
/// Two rounds of the SplitMix64 finalizer (Steele, Lea, Flood, OOPSLA 2014) over the mixed key.
inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t index, std::uint64_t stream) {
  const auto mix = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  };
  constexpr std::uint64_t golden = 0x9E3779B97F4A7C15u;
  return mix(mix(mix(seed + golden) + (stream + 1) * golden) + (index + 1) * golden);
}

/// The top 53 bits as a number in [0, 1).
inline double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace qerr
