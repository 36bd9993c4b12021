#pragma once

#include "simulate/lane_columns.hpp"

// Linear errors J e: contributions of the encoders to a coordinate, their sums, and the sums of their
// squares.

namespace qerr::lanes {
namespace {

/// Requested outputs of a batch as compile-time constants, which remove unused operations.
template <bool rows_, bool each_>
struct Wanted {
  static constexpr bool rows = rows_;  ///< PathErrorBatch::rows may be requested; otherwise only a tally
  static constexpr bool each = each_;  ///< PathErrorBatch::each
};

/// Adds differences of a channel from its shift at these instants to the tally.
template <class L>
[[gnu::always_inline]] inline void add_differences(const ChannelTally& t, std::size_t channel,
                                                   const L (&difference)[depth]) {
  constexpr auto lanes = lane_count<L>;
  L sum = load<L>(t.sum + channel * lanes), squares = load<L>(t.squares + channel * lanes);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    sum += difference[i];
    squares = fma(difference[i], difference[i], squares);
  }
  store(t.sum + channel * lanes, sum);
  store(t.squares + channel * lanes, squares);
}

/// Adds a channel at these instants to the tally and stores it for the rows.
template <class L>
[[gnu::always_inline]] inline void add_channel(const PathErrorBatch& b, const ErrorScratch<L>& scratch,
                                               std::size_t channel, bool fresh, const L (&value)[depth]) {
  if (b.rows) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) scratch.channels[depth * channel + i] = value[i];
  }
  if (!b.tally) return;
  if (fresh) b.tally->shift[channel] = value[0][0];
  const L shift = broadcast<L>(b.tally->shift[channel]);
  L difference[depth];
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) difference[i] = value[i] - shift;
  add_differences(*b.tally, channel, difference);
}

template <class L>
[[gnu::always_inline]] inline void add_peak(const ChannelTally& t, std::size_t channel,
                                            const L (&value)[depth]) {
  L peak = load<L>(t.peak + channel * lane_count<L>);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) peak = max(abs(value[i]), peak);
  store(t.peak + channel * lane_count<L>, peak);
}

/// Linear error of one coordinate at these instants: sums over the encoders.
template <class L>
struct Linear {
  L error[depth];  ///< without rows: minus the shifts of its contributions
  L sizes[depth];
  L squares[depth];  ///< if only their sum over the instants is requested: in the first vector
};

/// Adds (J C Delta)^2 of one encoder.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_squares(const L (&weighted)[depth], Linear<L>& all) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    L& sum = all.squares[Wanted::each ? i : 0];
    sum = fma(weighted[i], weighted[i], sum);
  }
}

/// Adds the contribution of one encoder to a coordinate.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_contribution(const PathErrorPlan& p, const PathErrorBatch& b,
                                                    std::size_t c, std::size_t e, bool fresh,
                                                    const ErrorScratch<L>& scratch,
                                                    const L (&weighted)[depth], Linear<L>& all) {
  const L* const residual_counts = scratch.residual_counts + depth * e;
  const std::size_t channel = p.coordinates * (2 + e) + c;
  if constexpr (Wanted::rows) {
    L part[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      part[i] = weighted[i] * residual_counts[i];
      all.error[i] += part[i];
    }
    add_channel(b, scratch, channel, fresh, part);
  } else {
    // The difference from the shift by one fused operation, which balances multiplication and addition units.
    double& first = b.tally->shift[channel];
    if (fresh) first = weighted[0][0] * residual_counts[0][0];
    const L shift = broadcast<L>(first);
    L difference[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      difference[i] = fma(weighted[i], residual_counts[i], -shift);
      all.error[i] += difference[i];
    }
    add_differences(*b.tally, channel, difference);
  }
}

template <bool bounded, class Wanted, class L>
[[gnu::always_inline]] inline Linear<L> linear_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                      std::size_t c, std::size_t at,
                                                      const ErrorScratch<L>& scratch) {
  Linear<L> all{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const L* const column = column_of(scratch, e) + p.rows[c];
    L weighted[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      weighted[i] = column[i * next_vector(scratch)];
      if (!bounded) weighted[i] = scratch.unbounded[i] ? broadcast<L>(__builtin_inf()) : weighted[i];
      all.sizes[i] += abs(weighted[i]);
    }
    add_contribution<Wanted>(p, b, c, e, b.fresh && at == 0, scratch, weighted, all);
    add_squares<Wanted>(weighted, all);
  }
  return all;
}

/// Adds the sum of all contributions to a coordinate, and that of their squares.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_linear(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                              std::size_t at, const ErrorScratch<L>& scratch,
                                              const Linear<L>& linear) {
  const std::size_t channel = p.coordinates + c;
  if constexpr (Wanted::rows) {
    add_channel(b, scratch, channel, b.fresh && at == 0, linear.error);
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
