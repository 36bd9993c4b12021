#pragma once

#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/lane_words.hpp"

// Surrogates in lanes: their noise, and what their encoders read.

namespace qerr::lanes {
namespace {

/// Whole numbers below 2^52 as what they are: they stand in the last bits of 2^52 + themselves.
template <class L>
[[gnu::always_inline]] inline L number_of(const Words<L>& whole) {
  return __builtin_bit_cast(L, whole | 0x4330000000000000u) - 0x1p52;
}

/// One step of SplitMix64: the sum of its four numbers of 16 bits, to mean 0 and variance 1.
template <class L>
[[gnu::always_inline]] inline L normal_like(Words<L>& generator) {
  constexpr double mean = 4 * 32767.5, sigma = 37837.22783634604;
  constexpr std::uint64_t every_second = 0x0000ffff0000ffffu;
  generator += 0x9E3779B97F4A7C15u;
  const Words<L> z = mixed<Words<L>>(generator);
  const Words<L> pairs = (z & every_second) + ((z >> 16) & every_second);
  return (number_of<L>((pairs & 0xffffffffu) + (pairs >> 32)) - mean) * (1 / sigma);
}

/// Some vectors of surrogates in registers.
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
  [[gnu::always_inline]] void keep(const SurrogateLanes& to, std::size_t lane) const {
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

/// Vectors whose noise the registers hold.
template <class L>
constexpr int noise_group = lane_count<L> == 8 ? 2 : 1;

template <class L>
void draw(const PathNoise& n, std::size_t draws, std::size_t width, const SurrogateLanes& lanes) {
  in_groups<noise_group<L>, L>(0, width, [&]<int group>(std::size_t lane) {
    SurrogatesAt<L, group> s(lanes, lane);
    for (std::size_t i = 0; i < draws; ++i) s.draw(n);
    s.keep(lanes, lane);
  });
}

template <class L, int group>
[[gnu::always_inline]] inline void read_group(const PathNoise& noise, const SurrogateRow* rows,
                                              std::size_t count, std::size_t width, std::size_t lane,
                                              const SurrogateLanes& lanes, double* residual, double* state) {
  using Rest = SurrogateRow::Rest;
  const PathNoise n = noise;  // as what is written might change it
  SurrogatesAt<L, group> s(lanes, lane);
  for (std::size_t k = 0; k < count; ++k) {
    const SurrogateRow& row = rows[k];
    s.draw(n);
#pragma GCC unroll 4
    for (int g = 0; g < group; ++g) {
      const std::size_t at = lane + g * lane_count<L>;
      if (row.rest == Rest::begins) store<L>(lanes.level + at, row.level * s.drawn[g]);
      L x = row.rest == Rest::none ? s.second[g] : load<L>(lanes.level + at);
      // What the model itself leaves to chance comes before the quantizer.
      if (n.chance) x = fma(row.chance, normal_like<L>(s.generator[g]), x);
      const L phase = load<L>(lanes.phase + at);
      x += row.place + phase;
      // Added to 1.5 2^52 a number is rounded to a whole one, which stands in the last bits of the sum.
      constexpr double shift = 0x1.8p52;
      const L shifted = x + shift;
      const Words<L> count_at =
          __builtin_bit_cast(Words<L>, shifted) + static_cast<std::uint64_t>(std::int64_t{row.whole});
      store<L>(residual + k * width + at, (shifted - shift) - (phase + row.reference));
      store<L>(state + k * width + at, number_of<L>(count_at & 3));
    }
  }
  s.keep(lanes, lane);
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
