#pragma once

#include "lane_columns.hpp"
#include "lane_rows.hpp"

namespace qerr::lanes {
namespace {

/// Takes a channel at these instants into the tally, and keeps it for the rows.
template <class L>
[[gnu::always_inline]] inline void add_channel(const PathErrorBatch& b, const ErrorRoom<L>& room,
                                               std::size_t channel, bool fresh, const L (&value)[depth]) {
  if (b.rows) {
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) room.channels[depth * channel + i] = value[i];
  }
  if (!b.tally) return;
  constexpr auto lanes = lane_count<L>;
  const ChannelTally& t = *b.tally;
  if (fresh) t.shift[channel] = value[0][0];
  const L shift = broadcast<L>(t.shift[channel]);
  L sum = load<L>(t.sum + channel * lanes), squares = load<L>(t.squares + channel * lanes);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    const L off = value[i] - shift;
    sum += off;
    squares = fma(off, off, squares);
  }
  store(t.sum + channel * lanes, sum);
  store(t.squares + channel * lanes, squares);
}

template <class L>
[[gnu::always_inline]] inline void add_peak(const ChannelTally& t, std::size_t channel,
                                            const L (&value)[depth]) {
  L peak = load<L>(t.peak + channel * lane_count<L>);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) peak = max(abs(value[i]), peak);
  store(t.peak + channel * lane_count<L>, peak);
}

/// What the encoders do to one coordinate at these instants.
template <class L>
struct Linear {
  L error[depth], sizes[depth], squares[depth];  ///< sums over the encoders
};

/// (J C Delta)^2 of coordinate and encoder k.
template <class L>
[[gnu::always_inline]] inline void add_squares(const PathErrorBatch& b, std::size_t k, std::size_t at,
                                               const L (&weighted)[depth], const L (&square)[depth]) {
  constexpr auto lanes = lane_count<L>;
  if (b.summed) {
    double* const to = b.summed + k * lanes;
    // From the factors: units that multiply have more time left than those that add.
    const L half = fma(weighted[1], weighted[1], square[0]), other = fma(weighted[3], weighted[3], square[2]);
    store(to, load<L>(to) + (half + other));
  }
  if (b.squares) {
    double* const to = b.squares + k * batch_size + at;
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) store(to + i * lanes, load<L>(to + i * lanes) + square[i]);
  }
}

template <bool bounded, class L>
[[gnu::always_inline]] inline Linear<L> linear_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                      std::size_t c, std::size_t at,
                                                      const ErrorRoom<L>& room) {
  Linear<L> all{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const L* const column = column_of(p, room, e) + p.rows[c];
    L weighted[depth], part[depth], square[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      const L missed = room.missed[depth * e + i];
      weighted[i] = column[i * next_vector(room)];
      if (!bounded) weighted[i] = room.unbounded[i] ? broadcast<L>(__builtin_inf()) : weighted[i];
      part[i] = weighted[i] * missed;
      square[i] = weighted[i] * weighted[i];
      all.sizes[i] += abs(weighted[i]);
      all.error[i] = fma(weighted[i], missed, all.error[i]);
      all.squares[i] += square[i];
    }
    add_channel(b, room, p.coordinates * (2 + e) + c, b.fresh && at == 0, part);
    add_squares(b, e * p.coordinates + c, at, weighted, square);
  }
  return all;
}

/// The mean of the errors in a coordinate at the i-th vector of instants; adds to `worst` what the sources
/// and the mean do.
template <class L>
[[gnu::always_inline]] inline L mean_error(const PathErrorPlan& p, std::size_t c, std::size_t i,
                                           const ErrorRoom<L>& room, L& worst) {
  L mean{};
  if (!p.biased && p.sources == 0) return mean;
  const std::size_t row = static_cast<std::size_t>(p.rows[c]) + i * next_vector(room);
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const L along = column_of(p, room, e)[row];
    mean = fma(p.columns[e].mean, along, mean);
    if (e >= p.encoders) worst = fma(p.columns[e].half_width, abs(along), worst);
  }
  worst += abs(mean);
  return mean;
}

/// Takes the bounds of a coordinate at these instants into the largest ones.
template <class L>
[[gnu::noinline]] void raise_bounds(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                    const ErrorRoom<L>& room) {
  L rigorous = load<L>(b.rigorous + c * lane_count<L>), deviation = load<L>(b.deviation + c * lane_count<L>);
  for (std::size_t i = 0; i < depth; ++i) {
    L worst{};
    for (std::size_t e = 0; e < p.encoders; ++e)
      worst += 0.5 * abs(column_of(p, room, e)[static_cast<std::size_t>(p.rows[c]) + i * next_vector(room)]);
    const L mean = mean_error(p, c, i, room, worst);
    L bound = min(worst + p.rotation, broadcast<L>(p.rotation_angle));
    if (p.rows[c] < 3) bound = worst + p.remainder + weighted_arms(p.chain, p.per_column, room.joints(i));
    rigorous = max(rigorous, bound);
    deviation = max(deviation, bound - abs(mean) + abs(mean - p.center_mean[c]));
  }
  store(b.rigorous + c * lane_count<L>, rigorous);
  store(b.deviation + c * lane_count<L>, deviation);
}

/// Mean and bounds of a coordinate along the path.
template <class L>
[[gnu::always_inline]] inline void bound_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                std::size_t c, std::size_t at, const Linear<L>& linear,
                                                const ErrorRoom<L>& room) {
  L mean[depth], largest{}, farthest{};
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    L worst = 0.5 * linear.sizes[i];
    mean[i] = mean_error(p, c, i, room, worst);
    largest = max(largest, worst);
    farthest = max(farthest, worst - abs(mean[i]) + abs(mean[i] - p.center_mean[c]));
  }
  if (p.biased) add_channel(b, room, p.coordinates * (2 + p.encoders) + c, b.fresh && at == 0, mean);
  if (p.rows[c] >= 6) return;
  const double most = p.rows[c] < 3 ? p.largest_remainder : p.rotation;
  // Records are rare, and the roots of the remainder dear.
  if (any<L>((largest + most > load<L>(b.rigorous + c * lane_count<L>)) |
             (farthest + most > load<L>(b.deviation + c * lane_count<L>))))
    raise_bounds(p, b, c, room);
}

template <class L>
[[gnu::always_inline]] inline bool any_unbounded(const PathErrorPlan& p, const ErrorRoom<L>& room) {
  return p.angles &&
         any<L>((room.unbounded[0] | room.unbounded[1]) | (room.unbounded[2] | room.unbounded[3]));
}

/// All channels of one coordinate at `depth` vectors of instants, those from `at`.
template <class L>
[[gnu::always_inline]] inline void add_coordinate(const PathErrorPlan& p, const PathErrorBatch& b,
                                                  std::size_t c, std::size_t at, bool unbounded,
                                                  const ErrorRoom<L>& room) {
  const bool fresh = b.fresh && at == 0;
  const auto row = static_cast<std::size_t>(p.rows[c]);
  L exact[depth];
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) exact[i] = room.pose[depth * row + i];
  add_channel(b, room, c, fresh, exact);
  if (b.tally) add_peak(*b.tally, c, exact);
  const bool bounded = !unbounded || row < 6 || row == 7;
  const Linear<L> linear =
      bounded ? linear_errors<true>(p, b, c, at, room) : linear_errors<false>(p, b, c, at, room);
  add_channel(b, room, p.coordinates + c, fresh, linear.error);
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i)
    store(b.variance + c * batch_size + at + i * lane_count<L>, linear.squares[i]);
  bound_errors(p, b, c, at, linear, room);
}

/// Errors of a batch of instants: of the pose, and what the Jacobian makes of those of the encoders
/// (operational_error).
template <class L>
void errors(const PathErrorPlan& p, const PathErrorBatch& b) {
  constexpr auto lanes = lane_count<L>;
  const ErrorRoom<L> room = furnished<L>(p, b.room);
  begin_errors(p, room);
  for (std::size_t at = 0; at < batch_size; at += depth * lanes) {
    for (std::size_t i = 0; i < depth; ++i) move_tip(p, b, at + i * lanes, i, room);
    const bool unbounded = any_unbounded(p, room);
    for (std::size_t c = 0; c < p.coordinates; ++c) add_coordinate(p, b, c, at, unbounded, room);
    for (std::size_t i = 0; b.rows && i < depth; ++i)
      into_rows<L>(reinterpret_cast<const double*>(room.channels + i), depth * lanes, p.width,
                   b.rows + (at + i * lanes) * p.width);
  }
}

}  // namespace
}  // namespace qerr::lanes
