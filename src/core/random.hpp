#pragma once

#include <cstdint>
#include <string_view>

namespace qerr {

/// Finalizer of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): a bijection of 64-bit words.
inline std::uint64_t mixed_bits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

inline constexpr std::uint64_t golden_ratio_bits = 0x9E3779B97F4A7C15u;

/// Hash of (seed, stream), from which `random_bits` derives its values.
inline std::uint64_t random_key(std::uint64_t seed, std::uint64_t stream) {
  return mixed_bits(mixed_bits(seed + golden_ratio_bits) + (stream + 1) * golden_ratio_bits);
}

/// Counter-based random numbers: the value depends on (seed, index, stream) alone, not on the number of
/// earlier draws, on threads, or on the standard library.
inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t index, std::uint64_t stream) {
  return mixed_bits(random_key(seed, stream) + (index + 1) * golden_ratio_bits);
}

/// Seed of member `index` of the stream `name`, such as draw 7 of "bootstrap".
///
/// A hash of all three: streams of neighbouring seeds, names or indices share no values (`seed + index`
/// would give seeds 1 and 2 all members but one in common).
inline std::uint64_t stream_seed(std::uint64_t seed, std::string_view name, std::uint64_t index = 0) {
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return random_bits(seed, index, hash);
}

/// The top 53 bits as a number in [0, 1).
inline double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace qerr
