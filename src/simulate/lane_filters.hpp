#pragma once

#include "kernels.hpp"
#include "qerr/core/lanes.hpp"

namespace qerr::lanes {
namespace {

/// One section on `group` vectors of channels, row after row. The integrators stay in registers, and the
/// vectors of a group fill the time that each of them waits for its last row.
template <class L, int group, bool second, SectionPlan::Output output>
void section_on(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows,
                std::size_t width, double* state, double* out) {
  using Output = SectionPlan::Output;
  constexpr auto lanes = lane_count<L>;
  L s1[group], s2[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    s1[g] = load<L>(state + g * lanes);
    s2[g] = second ? load<L>(state + width + g * lanes) : L{};
  }
  for (std::size_t row = 0; row < rows; ++row, in += stride, out += width) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) {
      const L x = load<L>(in + g * lanes);
      L high, band, low;
      if constexpr (second) {
        high = fma(-s.k1, s1[g], fma(-s.k0, s2[g], x));
        band = high + s1[g];
        low = s2[g] + band;
        s1[g] = band + high;
        s2[g] = low + band;
      } else {
        high = band = fma(-s.k0, s1[g], x);
        low = s1[g] + high;
        s1[g] = low + high;
      }
      L y;
      if constexpr (output == Output::low)
        y = s.b0 * low;
      else if constexpr (output == Output::band)
        y = s.b1 * band;
      else if constexpr (output == Output::high)
        y = s.b2 * high;
      else
        y = second ? fma(s.b0, low, fma(s.b1, band, s.b2 * high)) : fma(s.b0, low, s.b1 * band);
      store(out + g * lanes, y);
    }
  }
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    store(state + g * lanes, s1[g]);
    if (second) store(state + width + g * lanes, s2[g]);
  }
}

template <class L, int group>
void section_of_kind(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows,
                     std::size_t width, double* state, double* out) {
  using Output = SectionPlan::Output;
  const auto call = [&](auto* kernel) { kernel(s, in, stride, rows, width, state, out); };
  switch (s.output) {
    case Output::low:
      return call(s.second ? section_on<L, group, true, Output::low>
                           : section_on<L, group, false, Output::low>);
    case Output::band:
      return call(s.second ? section_on<L, group, true, Output::band>
                           : section_on<L, group, false, Output::band>);
    case Output::high:
      return call(section_on<L, group, true, Output::high>);
    case Output::all:
      return call(s.second ? section_on<L, group, true, Output::all>
                           : section_on<L, group, false, Output::all>);
  }
}

/// Vectors of a group: as many as the registers hold with what is kept of each.
template <class L>
constexpr int largest_group = lane_count<L> == 8 ? 8 : 4;

/// kernel<group>(first channel) for groups of vectors, the largest first.
template <int group, class L, class Kernel>
[[gnu::always_inline]] inline void in_groups(std::size_t c, std::size_t width, Kernel kernel) {
  for (; c + group * lane_count<L> <= width; c += group * lane_count<L>) kernel.template operator()<group>(c);
  if constexpr (group > 1)
    if (c < width) in_groups<group - 1, L>(c, width, kernel);
}

template <class L>
void section(const SectionPlan& s, const double* in, std::size_t stride, std::size_t rows, std::size_t width,
             double* state, double* out) {
  in_groups<largest_group<L>, L>(0, width, [&]<int group>(std::size_t c) {
    section_of_kind<L, group>(s, in + c, stride, rows, width, state + c, out + c);
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

template <class L, int group, bool peaks>
[[gnu::always_inline]] inline void tally_on(const double* in, std::size_t stride, std::size_t rows,
                                            std::size_t c, bool fresh, const ChannelTally& t) {
  constexpr auto lanes = lane_count<L>;
  L shift[group], sum[group], squares[group], peak[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    const std::size_t at = c + g * lanes;
    shift[g] = load<L>(fresh ? in + at : t.shift + at);
    sum[g] = load<L>(t.sum + at);
    squares[g] = load<L>(t.squares + at);
    peak[g] = peaks ? load<L>(t.peak + at) : L{};
  }
  for (std::size_t row = 0; row < rows; ++row) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) {
      const L value = load<L>(in + row * stride + c + g * lanes), off = value - shift[g];
      sum[g] += off;
      squares[g] = fma(off, off, squares[g]);
      if (peaks) peak[g] = max(abs(value), peak[g]);
    }
  }
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    const std::size_t at = c + g * lanes;
    if (fresh) store(t.shift + at, shift[g]);
    store(t.sum + at, sum[g]);
    store(t.squares + at, squares[g]);
    if (peaks) store(t.peak + at, peak[g]);
  }
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
