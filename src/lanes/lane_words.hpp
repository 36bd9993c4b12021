#pragma once

#include "lanes/lanes.hpp"

namespace qerr::lanes {
namespace {

template <class L>
struct WordsOf {
  typedef std::uint64_t type __attribute__((vector_size(sizeof(L))));
};
/// Unsigned 64-bit integers, as many as L has lanes.
template <class L>
using Words = typename WordsOf<L>::type;

/// `mixed_bits` of core/random.hpp in every lane.
template <class W>
[[gnu::always_inline]] inline W mixed(W z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace
}  // namespace qerr::lanes
