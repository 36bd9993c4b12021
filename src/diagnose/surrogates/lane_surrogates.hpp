#pragma once

#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/lanes.hpp"

// Noise and readings of surrogates, vectorized over surrogates.

namespace qerr::lanes {
namespace {

/// Converts integers below 2^52: they are the last bits of 2^52 plus the integer.
template <class L>
[[gnu::always_inline]] inline L number_of(const Words<L>& whole) {
  return __builtin_bit_cast(L, whole | 0x4330000000000000u) - 0x1p52;
}

/// One step of SplitMix64; the sum of its four numbers of 16 bits, scaled to mean 0 and variance 1.
template <class L>
[[gnu::always_inline]] inline L normal_like(Words<L>& generator) {
  constexpr double mean = 4 * 32767.5, sigma = 37837.22783634604;
  constexpr std::uint64_t every_second = 0x0000ffff0000ffffu;
  generator += 0x9E3779B97F4A7C15u;
  const Words<L> z = mixed<Words<L>>(generator);
  const Words<L> pairs = (z & every_second) + ((z >> 16) & every_second);
  return (number_of<L>((pairs & 0xffffffffu) + (pairs >> 32)) - mean) * (1 / sigma);
}

/// State of several vectors of surrogates in registers.
template <class L, int group>
struct SurrogatesAt {
  Words<L> generator[group];
  L first[group], second[group], drawn[group];

  [[gnu::always_inline]] SurrogatesAt(const SurrogateLanes& from, std::size_t lane) {
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      __builtin_memcpy(&generator[g], from.generator + at, sizeof(L));
      first[g] = load<L>(from.first + at);
      second[g] = load<L>(from.second + at);
    }
  }
  [[gnu::always_inline]] void store_to(const SurrogateLanes& to, std::size_t lane) const {
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      __builtin_memcpy(to.generator + at, &generator[g], sizeof(L));
      store(to.first + at, first[g]);
      store(to.second + at, second[g]);
    }
  }
  [[gnu::always_inline]] void draw(const PathNoise& n) {
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      drawn[g] = normal_like<L>(generator[g]);
      first[g] = fma(n.pole, first[g], (1 - n.pole) * n.sigma * drawn[g]);
      second[g] = fma(n.pole, second[g], (1 - n.pole) * first[g]);
    }
  }
};

/// Vectors whose state fits the registers.
template <class L>
constexpr int noise_group = lane_count<L> == 8 ? 2 : 1;

template <class L>
void draw(const PathNoise& n, std::size_t draws, std::size_t width, const SurrogateLanes& lanes) {
  in_groups<noise_group<L>, L>(0, width, [&]<int group>(std::size_t lane) {
    SurrogatesAt<L, group> s(lanes, lane);
    for (std::size_t i = 0; i < draws; ++i) s.draw(n);
    s.store_to(lanes, lane);
  });
}

template <class L, int group>
[[gnu::always_inline]] inline void read_group(const PathNoise& noise, const SurrogateRow* rows,
                                              std::size_t count, std::size_t width, std::size_t lane,
                                              const SurrogateLanes& lanes, double* residual, double* state) {
  using Standstill = SurrogateRow::Standstill;
  const PathNoise n = noise;  // a copy: stores to the outputs may alias it
  SurrogatesAt<L, group> s(lanes, lane);
  for (std::size_t k = 0; k < count; ++k) {
    const SurrogateRow& row = rows[k];
    s.draw(n);
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      if (row.standstill == Standstill::begins)
        store<L>(lanes.standstill + at, row.standstill_sigma * s.drawn[g]);
      L x = row.standstill == Standstill::none ? s.second[g] : load<L>(lanes.standstill + at);
      // Random effects of the model act before the quantizer.
      if (n.random_effects) x = fma(row.random_sigma, normal_like<L>(s.generator[g]), x);
      const L phase = load<L>(lanes.phase + at);
      x += row.offset + phase;
      // Adding 1.5 2^52 rounds to the nearest integer, which is then in the last bits of the sum.
      constexpr double shift = 0x1.8p52;
      const L shifted = x + shift;
      const Words<L> count_at =
          __builtin_bit_cast(Words<L>, shifted) + static_cast<std::uint64_t>(std::int64_t{row.count});
      store<L>(residual + k * width + at, (shifted - shift) - (phase + row.reference));
      store<L>(state + k * width + at, number_of<L>(count_at & 3));
    }
  }
  s.store_to(lanes, lane);
}

template <class L>
void read(const PathNoise& noise, const SurrogateRow* rows, std::size_t count, std::size_t width,
          const SurrogateLanes& lanes, double* residual, double* state) {
  in_groups<noise_group<L>, L>(0, width, [&]<int group>(std::size_t lane) {
    read_group<L, group>(noise, rows, count, width, lane, lanes, residual, state);
  });
}

}  // namespace
}  // namespace qerr::lanes
