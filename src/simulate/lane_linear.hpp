#pragma once

#include <utility>

#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "simulate/lane_columns.hpp"

namespace qerr::lanes {

// Linear errors J e: contributions of the encoders to a coordinate, their sums, and the sums of their
// squares.

namespace {

/// Stores a channel at these instants for the rows.
template <class L>
[[gnu::always_inline]] inline void set_channel(const ErrorScratch<L>& scratch, std::size_t channel,
                                               const L (&value)[depth]) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) scratch.channels[depth * channel + i] = value[i];
}

/// Linear error of one coordinate at these instants: sums over the encoders.
template <class L>
struct Linear {
  L error[depth], sizes[depth], squares[depth];
};

/// @param bounded  no lane is at the gimbal lock
template <class L>
[[gnu::always_inline]] inline Linear<L> linear_errors(const PathErrorPlan& p, std::size_t c, bool bounded,
                                                      const ErrorScratch<L>& scratch) {
  Linear<L> all{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const L* const column = column_of(scratch, e) + p.rows[c];
    const L* const residual_counts = scratch.residual_counts + depth * e;
    L part[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      L weighted = column[i * next_vector(scratch)];
      if (!bounded) weighted = scratch.unbounded[i] ? broadcast<L>(__builtin_inf()) : weighted;
      part[i] = weighted * residual_counts[i];
      all.error[i] += part[i];
      all.sizes[i] += abs(weighted);
      all.squares[i] = fma(weighted, weighted, all.squares[i]);
    }
    set_channel(scratch, p.coordinates * (2 + e) + c, part);
  }
  return all;
}

/// One step of transposing a square of lanes: exchanges blocks of rows `a` and `b`, which are `distance`
/// apart.
template <std::size_t distance, class L, std::size_t... i>
[[gnu::always_inline]] inline void cross_over(L& a, L& b, std::index_sequence<i...>) {
  constexpr auto n = sizeof...(i);
  const L first = __builtin_shufflevector(a, b, (i & distance ? n + i - distance : i)...);
  b = __builtin_shufflevector(a, b, (i & distance ? n + i : i + distance)...);
  a = first;
}

template <std::size_t distance, class L>
[[gnu::always_inline]] inline void cross_rows(L* rows) {
  constexpr auto n = lane_count<L>;
#pragma GCC unroll 8
  for (std::size_t row = 0; row < n; ++row)
    if (!(row & distance))
      cross_over<distance>(rows[row], rows[row + distance], std::make_index_sequence<n>{});
  if constexpr (distance > 1) cross_rows<distance / 2>(rows);
}

/// Transposes channels of one vector of instants, `stride` numbers apart, into rows of `width` channels.
template <class L>
[[gnu::always_inline]] inline void into_rows(const double* channels, std::size_t stride, std::size_t width,
                                             double* rows) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) square[i] = load<L>(channels + (c + i) * stride);
    cross_rows<n / 2>(square);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) store(rows + i * width + c, square[i]);
  }
}

/// The mean error of a coordinate at the i-th vector of instants; adds the contributions of the mean and of
/// the sources to `worst`.
template <class L>
[[gnu::always_inline]] inline L mean_error(const PathErrorPlan& p, std::size_t c, std::size_t i,
                                           const ErrorScratch<L>& scratch, L& worst) {
  L mean{};
  if (!p.biased && p.sources == 0) return mean;
  const std::size_t row = static_cast<std::size_t>(p.rows[c]) + i * next_vector(scratch);
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const L along = column_of(scratch, e)[row];
    mean = fma(p.columns[e].mean, along, mean);
    if (e >= p.encoders) worst = fma(p.columns[e].half_width, abs(along), worst);
  }
  worst += abs(mean);
  return mean;
}

/// Updates the largest bounds of a coordinate with those at these instants.
template <class L>
[[gnu::noinline]] void raise_bounds(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                    const ErrorScratch<L>& scratch) {
  L rigorous = load<L>(b.rigorous + c * lane_count<L>), deviation = load<L>(b.deviation + c * lane_count<L>);
  for (std::size_t i = 0; i < depth; ++i) {
    L worst{};
    for (std::size_t e = 0; e < p.encoders; ++e)
      worst +=
          0.5 * abs(column_of(scratch, e)[static_cast<std::size_t>(p.rows[c]) + i * next_vector(scratch)]);
    const L mean = mean_error(p, c, i, scratch, worst);
    L bound = min(worst + p.rotation, broadcast<L>(p.rotation_angle));
    if (p.rows[c] < 3)
      bound = worst + p.remainder + weighted_column_norms(p.chain, p.per_column, scratch.joints(i));
    rigorous = max(rigorous, bound);
    deviation = max(deviation, bound - abs(mean) + abs(mean - p.center_mean[c]));
  }
  store(b.rigorous + c * lane_count<L>, rigorous);
  store(b.deviation + c * lane_count<L>, deviation);
}

/// Mean and bounds of a coordinate along the path.
template <class L>
[[gnu::always_inline]] inline void bound_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                std::size_t c, const L (&sizes)[depth],
                                                const ErrorScratch<L>& scratch) {
  L mean[depth], largest{}, farthest{};
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    L worst = 0.5 * sizes[i];
    mean[i] = mean_error(p, c, i, scratch, worst);
    largest = max(largest, worst);
    farthest = max(farthest, worst - abs(mean[i]) + abs(mean[i] - p.center_mean[c]));
  }
  if (p.biased) set_channel(scratch, p.coordinates * (2 + p.encoders) + c, mean);
  if (p.rows[c] >= 6) return;
  const double most = p.rows[c] < 3 ? p.largest_remainder : p.rotation;
  // New maxima are rare; skip the square roots of the remainder otherwise.
  if (any<L>((largest + most > load<L>(b.rigorous + c * lane_count<L>)) |
             (farthest + most > load<L>(b.deviation + c * lane_count<L>))))
    raise_bounds(p, b, c, scratch);
}

template <class L>
[[gnu::always_inline]] inline bool any_unbounded(const PathErrorPlan& p, const ErrorScratch<L>& scratch) {
  return p.angles && any<L>((scratch.unbounded[0] | scratch.unbounded[1]) |
                            (scratch.unbounded[2] | scratch.unbounded[3]));
}

/// Computes all channels of all coordinates at `depth` vectors of instants from `at`.
template <class L>
[[gnu::noinline]] void set_coordinates(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                       const ErrorScratch<L>& scratch) {
  const bool unbounded = any_unbounded(p, scratch);
  for (std::size_t c = 0; c < p.coordinates; ++c) {
    const auto row = static_cast<std::size_t>(p.rows[c]);
    L exact[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) exact[i] = scratch.pose[depth * row + i];
    set_channel(scratch, c, exact);
    const Linear<L> linear = linear_errors(p, c, !unbounded || row < 6, scratch);
    set_channel(scratch, p.coordinates + c, linear.error);
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i)
      store(b.variance + c * batch_size + at + i * lane_count<L>, linear.squares[i]);
    bound_errors(p, b, c, linear.sizes, scratch);
  }
}

/// Errors of a batch of instants: exact pose error, and linear errors J e of the encoders
/// (operational_error).
template <class L>
void errors(const PathErrorPlan& p, const PathErrorBatch& b) {
  constexpr auto lanes = lane_count<L>;
  const ErrorScratch<L> scratch = scratch_of<L>(p, b.scratch);
  begin_errors(p, scratch);
  for (std::size_t at = 0; at < batch_size; at += depth * lanes) {
    for (std::size_t i = 0; i < depth; ++i) move_tip(p, b, at + i * lanes, i, scratch);
    set_coordinates(p, b, at, scratch);
    for (std::size_t i = 0; i < depth; ++i)
      into_rows<L>(reinterpret_cast<const double*>(scratch.channels + i), depth * lanes, p.width,
                   b.rows + (at + i * lanes) * p.width);
  }
}

}  // namespace

}  // namespace qerr::lanes
