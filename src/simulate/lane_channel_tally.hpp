#pragma once

#include "lanes/lanes.hpp"
#include "simulate/kernels.hpp"

namespace qerr::lanes {
namespace {

/// Sums of `group` vectors of channels in registers.
template <class L, int group, bool peaks>
struct TallyLanes {
  L shift[group], sum[group], squares[group], peak[group];

  [[gnu::always_inline]] TallyLanes(const ChannelTally& t, std::size_t c) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) {
      const std::size_t at = c + g * lane_count<L>;
      shift[g] = load<L>(t.shift + at);
      sum[g] = load<L>(t.sum + at);
      squares[g] = load<L>(t.squares + at);
      peak[g] = peaks ? load<L>(t.peak + at) : L{};
    }
  }
  [[gnu::always_inline]] void add(int g, const L& value) {
    const L deviation = value - shift[g];
    sum[g] += deviation;
    squares[g] = fma(deviation, deviation, squares[g]);
    if constexpr (peaks) peak[g] = max(abs(value), peak[g]);
  }
  [[gnu::always_inline]] void store_to(const ChannelTally& t, std::size_t c) const {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) {
      const std::size_t at = c + g * lane_count<L>;
      store(t.sum + at, sum[g]);
      store(t.squares + at, squares[g]);
      if constexpr (peaks) store(t.peak + at, peak[g]);
    }
  }
};

template <class L, int group, bool peaks>
[[gnu::always_inline]] inline void tally_on(const double* in, std::size_t stride, std::size_t rows,
                                            std::size_t c, bool fresh, const ChannelTally& t) {
  constexpr auto lanes = lane_count<L>;
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g)
    if (fresh) store(t.shift + c + g * lanes, load<L>(in + c + g * lanes));
  TallyLanes<L, group, peaks> tally(t, c);
  for (std::size_t row = 0; row < rows; ++row) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) tally.add(g, load<L>(in + row * stride + c + g * lanes));
  }
  tally.store_to(t, c);
}

template <class L>
void tally(const double* in, std::size_t stride, std::size_t rows, std::size_t width, std::size_t peaks,
           bool fresh, const ChannelTally& t) {
  in_groups<4, L>(0, width, [&]<int group>(std::size_t c) {
    c < peaks ? tally_on<L, group, true>(in, stride, rows, c, fresh, t)
              : tally_on<L, group, false>(in, stride, rows, c, fresh, t);
  });
}

}  // namespace
}  // namespace qerr::lanes
