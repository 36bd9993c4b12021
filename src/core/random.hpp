#pragma once

#include <cstdint>

namespace qerr {

/// Finalizer of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
inline std::uint64_t mixed_bits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

inline constexpr std::uint64_t golden_ratio_bits = 0x9E3779B97F4A7C15u;

/// What seed and stream contribute to `random_bits`.
inline std::uint64_t random_key(std::uint64_t seed, std::uint64_t stream) {
  return mixed_bits(mixed_bits(seed + golden_ratio_bits) + (stream + 1) * golden_ratio_bits);
}

/// Counter-based random numbers: the value depends on (seed, index, stream) alone, never on how many were
/// drawn before, on threads, or on the standard library.
///
/// Rounds of SplitMix64's finalizer over the mixed key.
inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t index, std::uint64_t stream) {
  return mixed_bits(random_key(seed, stream) + (index + 1) * golden_ratio_bits);
}

/// The top 53 bits as a number in [0, 1).
inline double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace qerr
