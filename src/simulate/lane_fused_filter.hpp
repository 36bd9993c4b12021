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

// Rows of channels through one or two sections and into their tally, without storing rows in between.

namespace {

using Kind = FusedSection::Kind;

/// The factors of a section in lanes.
template <class L>
struct FusedLanes {
  L e, minus_k, a, b;

  [[gnu::always_inline]] explicit FusedLanes(const FusedSection& s)
      : e(broadcast<L>(s.e)), minus_k(broadcast<L>(-s.k)), a(broadcast<L>(s.a)), b(broadcast<L>(s.b)) {}
};

/// The states of a section for one vector of channels.
template <class L>
struct FusedState {
  L s, r;
};

/// Whether the section has one state.
constexpr bool of_first_order(Kind kind) {
  return kind == Kind::first || kind == Kind::rise || kind == Kind::lag;
}

/// One sample through a section.
template <Kind kind, class L>
[[gnu::always_inline]] inline L pass(const FusedLanes<L>& section, const L& x, FusedState<L>& state) {
  const L before = state.s, r = state.r;
  if constexpr (kind == Kind::none) return x;
  L next = fma(section.e, before, x);
  if constexpr (!of_first_order(kind)) {
    next = fma(section.minus_k, r, next);
    state.r = r + next;
  }
  state.s = next;
  if constexpr (kind == Kind::lag) return next;
  if constexpr (kind == Kind::rise) return next - before;
  if constexpr (kind == Kind::low) return fma(0.25, next - before, r);
  const L y = fma(section.a, before, next);
  if constexpr (kind == Kind::second) return fma(section.b, r, y);
  return y;
}

template <Kind kind, class L>
[[gnu::always_inline]] inline FusedState<L> state_at(const double* from, std::size_t width) {
  FusedState<L> state{};
  if constexpr (kind != Kind::none) state.s = load<L>(from);
  if constexpr (kind != Kind::none && !of_first_order(kind)) state.r = load<L>(from + width);
  return state;
}

template <Kind kind, class L>
[[gnu::always_inline]] inline void keep(const FusedState<L>& state, double* to, std::size_t width) {
  if constexpr (kind != Kind::none) store(to, state.s);
  if constexpr (kind != Kind::none && !of_first_order(kind)) store(to + width, state.r);
}

/// All states of a filter for one vector of channels.
template <class L, int differences, Kind one, Kind two>
struct FusedStates {
  FusedState<L> first, last;
  L past[differences > 0 ? differences : 1];

  [[gnu::always_inline]] void load_from(const double* from, std::size_t width) {
    first = state_at<one, L>(from, width);
    last = state_at<two, L>(from + 2 * width, width);
    for (int d = 0; d < differences; ++d) past[d] = load<L>(from + static_cast<std::size_t>(4 + d) * width);
  }
  [[gnu::always_inline]] void store_to(double* to, std::size_t width) const {
    keep<one>(first, to, width);
    keep<two>(last, to + 2 * width, width);
    for (int d = 0; d < differences; ++d) store(to + static_cast<std::size_t>(4 + d) * width, past[d]);
  }
  [[gnu::always_inline]] L pass_on(L x, const FusedLanes<L>& of_first, const FusedLanes<L>& of_last) {
#pragma GCC unroll 2
    for (int d = 0; d < differences; ++d) {
      const L input = x;
      x = input - past[d];
      past[d] = input;
    }
    return pass<two>(of_last, pass<one>(of_first, x, first), last);
  }
};

/// Arguments of a kernel.
struct FusedRows {
  const double* in;
  std::size_t stride, rows, width;
  double* state;
};

/// `group` vectors of channels from the c-th on, row after row.
template <class L, int group, bool peaks, int differences, Kind one, Kind two>
[[gnu::noinline]] void fused_on(const FusedPlan& f, const FusedRows& rows, std::size_t c, bool fresh,
                                const ChannelTally& t) {
  constexpr auto lanes = lane_count<L>;
  const FusedLanes<L> first(f.sections[0]), last(f.sections[1]);
  const double* in = rows.in + c;
  FusedStates<L, differences, one, two> states[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    states[g].load_from(rows.state + c + g * lanes, rows.width);
    if (fresh) {  // sums are about the first output
      auto copy = states[g];
      store(t.shift + c + g * lanes, copy.pass_on(load<L>(in + g * lanes), first, last));
    }
  }
  TallyLanes<L, group, peaks> tally(t, c);
  for (std::size_t row = 0; row < rows.rows; ++row, in += rows.stride) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) tally.add(g, states[g].pass_on(load<L>(in + g * lanes), first, last));
  }
  tally.store_to(t, c);
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) states[g].store_to(rows.state + c + g * lanes, rows.width);
}

/// Calls call(kernel) with the kernel for a filter's sections.
template <class L, int group, bool peaks, int differences, class Call>
void with_sections(Kind one, Kind two, Call call) {
  const auto select = [&]<Kind a, Kind b>() {
    if constexpr (is_fusible(differences, a, b))
      if (one == a && two == b) call(fused_on<L, group, peaks, differences, a, b>);
  };
  select.template operator()<Kind::first, Kind::none>();
  select.template operator()<Kind::first, Kind::first>();
  select.template operator()<Kind::first, Kind::second>();
  select.template operator()<Kind::rise, Kind::lag>();
  select.template operator()<Kind::second, Kind::none>();
  select.template operator()<Kind::second, Kind::second>();
  select.template operator()<Kind::low, Kind::low>();
}

template <class L, int group, bool peaks>
void fused_of_kind(const FusedPlan& f, const FusedRows& rows, std::size_t c, bool fresh,
                   const ChannelTally& t) {
  const auto call = [&](auto* kernel) { kernel(f, rows, c, fresh, t); };
  const Kind one = f.sections[0].kind, two = f.sections[1].kind;
  if (f.differences == 0) with_sections<L, group, peaks, 0>(one, two, call);
  if (f.differences == 1) with_sections<L, group, peaks, 1>(one, two, call);
  if (f.differences == 2) with_sections<L, group, peaks, 2>(one, two, call);
}

/// Vectors of a group: as many as the registers hold with their states and sums.
template <class L>
constexpr std::size_t largest_fused = lane_count<L> == 8 ? 3 : 2;

/// Groups of nearly equal size: the vectors of a group hide the latency of the recursion of each.
template <class L>
void filter_and_tally(const FusedPlan& f, const double* in, std::size_t stride, std::size_t rows,
                      std::size_t width, std::size_t peaks, bool fresh, double* state,
                      const ChannelTally& t) {
  constexpr std::size_t lanes = lane_count<L>, largest = largest_fused<L>;
  const FusedRows all{in, stride, rows, width, state};
  std::size_t vectors = width / lanes, groups = (vectors + largest - 1) / largest, c = 0;
  for (; groups > 0; --groups) {
    const std::size_t size = (vectors + groups - 1) / groups;
    const auto on = [&]<int group>() {
      if constexpr (group <= largest)
        if (size == group)
          c < peaks ? fused_of_kind<L, group, true>(f, all, c, fresh, t)
                    : fused_of_kind<L, group, false>(f, all, c, fresh, t);
    };
    on.template operator()<1>();
    on.template operator()<2>();
    on.template operator()<3>();
    vectors -= size;
    c += size * lanes;
  }
}

}  // namespace

}  // namespace qerr::lanes
