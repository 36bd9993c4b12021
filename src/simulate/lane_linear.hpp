#pragma once

#include "simulate/lane_columns.hpp"

// What the Jacobian makes of the errors of encoders: their parts in a coordinate, the sums of these, and of
// their squares.

namespace qerr::lanes {
namespace {

/// What is wanted of a batch, known to the compiler: it decides which operations are left.
template <bool rows_, bool each_>
struct Wanted {
  static constexpr bool rows = rows_;  ///< PathErrorBatch::rows may be wanted; a tally alone if not
  static constexpr bool each = each_;  ///< PathErrorBatch::each
};

/// Differences of a channel at these instants from its shift into the tally.
template <class L>
[[gnu::always_inline]] inline void add_differences(const ChannelTally& t, std::size_t channel,
                                                   const L (&off)[depth]) {
  constexpr auto lanes = lane_count<L>;
  L sum = load<L>(t.sum + channel * lanes), squares = load<L>(t.squares + channel * lanes);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    sum += off[i];
    squares = fma(off[i], off[i], squares);
  }
  store(t.sum + channel * lanes, sum);
  store(t.squares + channel * lanes, squares);
}

/// Takes a channel at these instants into the tally, and keeps it for the rows.
template <class L>
[[gnu::always_inline]] inline void add_channel(const PathErrorBatch& b, const ErrorRoom<L>& room,
                                               std::size_t channel, bool fresh, const L (&value)[depth]) {
  if (b.rows) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) room.channels[depth * channel + i] = value[i];
  }
  if (!b.tally) return;
  if (fresh) b.tally->shift[channel] = value[0][0];
  const L shift = broadcast<L>(b.tally->shift[channel]);
  L off[depth];
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) off[i] = value[i] - shift;
  add_differences(*b.tally, channel, off);
}

template <class L>
[[gnu::always_inline]] inline void add_peak(const ChannelTally& t, std::size_t channel,
                                            const L (&value)[depth]) {
  L peak = load<L>(t.peak + channel * lane_count<L>);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) peak = max(abs(value[i]), peak);
  store(t.peak + channel * lane_count<L>, peak);
}

/// What the encoders do to one coordinate at these instants: sums over the encoders.
template <class L>
struct Linear {
  L error[depth];  ///< where no rows are wanted, less the shifts of its parts
  L sizes[depth];
  L squares[depth];  ///< where only their sum over the instants is wanted, it stands in the first
};

/// (J C Delta)^2 of coordinate and encoder k.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_squares(const PathErrorBatch& b, std::size_t k, std::size_t at,
                                               const L (&weighted)[depth], Linear<L>& all) {
  constexpr auto lanes = lane_count<L>;
  L sum = weighted[0] * weighted[0];
#pragma GCC unroll 3
  for (std::size_t i = 1; i < depth; ++i) sum = fma(weighted[i], weighted[i], sum);
  if constexpr (Wanted::each) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) all.squares[i] = fma(weighted[i], weighted[i], all.squares[i]);
  } else {
    all.squares[0] += sum;
  }
  if (b.summed) store(b.summed + k * lanes, load<L>(b.summed + k * lanes) + sum);
  if (b.squares) {
    double* const to = b.squares + k * batch_size + at;
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i)
      store(to + i * lanes, fma(weighted[i], weighted[i], load<L>(to + i * lanes)));
  }
}

/// One encoder's part in a coordinate.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_part(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                            std::size_t e, bool fresh, const ErrorRoom<L>& room,
                                            const L (&weighted)[depth], Linear<L>& all) {
  const L* const missed = room.missed + depth * e;
  const std::size_t channel = p.coordinates * (2 + e) + c;
  if constexpr (Wanted::rows) {
    L part[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      part[i] = weighted[i] * missed[i];
      all.error[i] += part[i];
    }
    add_channel(b, room, channel, fresh, part);
  } else {
    // The tally's difference at once: of the units that multiply and those that add none waits for the other.
    double& first = b.tally->shift[channel];
    if (fresh) first = weighted[0][0] * missed[0][0];
    const L shift = broadcast<L>(first);
    L off[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      off[i] = fma(weighted[i], missed[i], -shift);
      all.error[i] += off[i];
    }
    add_differences(*b.tally, channel, off);
  }
}

template <bool bounded, class Wanted, class L>
[[gnu::always_inline]] inline Linear<L> linear_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                      std::size_t c, std::size_t at,
                                                      const ErrorRoom<L>& room) {
  Linear<L> all{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const L* const column = column_of(room, e) + p.rows[c];
    L weighted[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      weighted[i] = column[i * next_vector(room)];
      if (!bounded) weighted[i] = room.unbounded[i] ? broadcast<L>(__builtin_inf()) : weighted[i];
      all.sizes[i] += abs(weighted[i]);
    }
    add_part<Wanted>(p, b, c, e, b.fresh && at == 0, room, weighted, all);
    add_squares<Wanted>(b, e * p.coordinates + c, at, weighted, all);
  }
  return all;
}

/// The sum of all parts of a coordinate, and that of their squares.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_linear(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                              std::size_t at, const ErrorRoom<L>& room,
                                              const Linear<L>& linear) {
  const std::size_t channel = p.coordinates + c;
  if constexpr (Wanted::rows) {
    add_channel(b, room, channel, b.fresh && at == 0, linear.error);
  } else {
    if (b.fresh && at == 0) {
      double& shift = b.tally->shift[channel] = 0;
      for (std::size_t e = 0; e < p.encoders; ++e) shift += b.tally->shift[p.coordinates * (2 + e) + c];
    }
    add_differences(*b.tally, channel, linear.error);
  }
  if constexpr (Wanted::each) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i)
      store(b.variance + c * batch_size + at + i * lane_count<L>, linear.squares[i]);
  } else {
    double* const to = b.variance + c * batch_size;
    store(to, at == 0 ? linear.squares[0] : load<L>(to) + linear.squares[0]);
  }
}

}  // namespace
}  // namespace qerr::lanes
