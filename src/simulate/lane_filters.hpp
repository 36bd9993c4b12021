#pragma once

#include "lanes/lanes.hpp"
#include "simulate/kernels.hpp"

namespace qerr::lanes {
namespace {

/// The factors of a section in lanes: read before all rows, as what is written might change them.
template <class L>
struct SectionLanes {
  L minus_k0, minus_k1, b0, b1, b2;

  [[gnu::always_inline]] explicit SectionLanes(const SectionPlan& s)
      : minus_k0(broadcast<L>(-s.k0)),
        minus_k1(broadcast<L>(-s.k1)),
        b0(broadcast<L>(s.b0)),
        b1(broadcast<L>(s.b1)),
        b2(broadcast<L>(s.b2)) {}
};

/// The integrators of a section for one vector of channels.
template <class L>
struct Integrators {
  L s1, s2;
};

/// A sample through a section. Additions and multiplications keep the units of both busy: a state goes on by
/// twice what its integrator took in.
template <bool second, SectionPlan::Output output, class L>
[[gnu::always_inline]] inline L pass(const SectionLanes<L>& s, const L& x, Integrators<L>& state) {
  using Output = SectionPlan::Output;
  L high, band, low;
  if constexpr (second) {
    high = fma(s.minus_k1, state.s1, fma(s.minus_k0, state.s2, x));
    band = high + state.s1;
    low = state.s2 + band;
    state.s1 = fma(2, high, state.s1);
    state.s2 = low + band;
  } else {
    high = band = fma(s.minus_k0, state.s1, x);
    low = state.s1 + high;
    state.s1 = fma(2, high, state.s1);
  }
  if constexpr (output == Output::low) return low;
  if constexpr (output == Output::band) return band;
  if constexpr (output == Output::high) return high;
  if constexpr (output == Output::scaled_low) return s.b0 * low;
  if constexpr (output == Output::scaled_band) return s.b1 * band;
  if constexpr (output == Output::scaled_high) return s.b2 * high;
  if constexpr (second) return fma(s.b0, low, fma(s.b1, band, s.b2 * high));
  return fma(s.b0, low, s.b1 * band);
}

/// One section on `group` vectors of channels, row after row. The integrators stay in registers, and the
/// vectors of a group fill the time that each of them waits for its last row.
template <class L, int group, bool second, SectionPlan::Output output>
void section_on(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows,
                std::size_t width, double* state, double* out) {
  constexpr auto lanes = lane_count<L>;
  const SectionLanes<L> section(s);
  Integrators<L> of[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    of[g].s1 = load<L>(state + g * lanes);
    of[g].s2 = second ? load<L>(state + width + g * lanes) : L{};
  }
  for (std::size_t row = 0; row < rows; ++row, in += stride, out += width) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g)
      store(out + g * lanes, pass<second, output>(section, load<L>(in + g * lanes), of[g]));
  }
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    store(state + g * lanes, of[g].s1);
    if (second) store(state + width + g * lanes, of[g].s2);
  }
}

template <class L, int group, bool second>
void section_of_kind(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows,
                     std::size_t width, double* state, double* out) {
  using Output = SectionPlan::Output;
  const auto call = [&](auto* kernel) { kernel(s, in, stride, rows, width, state, out); };
  switch (s.output) {
    case Output::low:
      return call(section_on<L, group, second, Output::low>);
    case Output::band:
      return call(section_on<L, group, second, Output::band>);
    case Output::high:
      return call(section_on<L, group, second, Output::high>);
    case Output::scaled_low:
      return call(section_on<L, group, second, Output::scaled_low>);
    case Output::scaled_band:
      return call(section_on<L, group, second, Output::scaled_band>);
    case Output::scaled_high:
      return call(section_on<L, group, second, Output::scaled_high>);
    case Output::all:
      return call(section_on<L, group, second, Output::all>);
  }
}

/// Vectors of a group: as many as the registers hold with what is kept of each.
template <class L>
constexpr int largest_group = lane_count<L> == 8 ? 8 : 4;

template <class L>
void section(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows, std::size_t width,
             double* state, double* out) {
  in_groups<largest_group<L>, L>(0, width, [&]<int group>(std::size_t c) {
    s.second ? section_of_kind<L, group, true>(s, in + c, stride, rows, width, state + c, out + c)
             : section_of_kind<L, group, false>(s, in + c, stride, rows, width, state + c, out + c);
  });
}

template <class L>
void taps(const double* taps, std::size_t count, const double* in, std::size_t rows, std::size_t width,
          double* out) {
  constexpr auto lanes = lane_count<L>;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t c = 0; c < width; c += lanes) {
      L sum{};
      const double* from = in + row * width + c;
      for (std::size_t k = 0; k < count; ++k, from -= width) sum = fma(taps[k], load<L>(from), sum);
      store(out + row * width + c, sum);
    }
}

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
    const L off = value - shift[g];
    sum[g] += off;
    squares[g] = fma(off, off, squares[g]);
    if constexpr (peaks) peak[g] = max(abs(value), peak[g]);
  }
  [[gnu::always_inline]] void put(const ChannelTally& t, std::size_t c) const {
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
  tally.put(t, c);
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
