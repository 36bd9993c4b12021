#pragma once

#include <utility>

#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "simulate/lane_columns.hpp"

namespace qerr::lanes {

// Linear errors J e: contributions of the encoders to a coordinate, their sums, and the sums of their
// squares.

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

// Transposes numbers of many instants from channels into rows, and sums them.

namespace {

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

template <class L>
[[gnu::always_inline]] inline double sum_of(const L& lanes) {
  double sum = 0;
  for (std::size_t i = 0; i < lane_count<L>; ++i) sum += lanes[i];
  return sum;
}

template <class L>
double sum_between(const double* row, std::size_t first, std::size_t last) {
  constexpr auto lanes = lane_count<L>;
  L sum{};
  for (; first + lanes <= last; first += lanes) sum += load<L>(row + first);
  double all = sum_of(sum);
  for (; first < last; ++first) all += row[first];
  return all;
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
                                                std::size_t c, std::size_t at, const Linear<L>& linear,
                                                const ErrorScratch<L>& scratch) {
  L mean[depth], largest{}, farthest{};
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    L worst = 0.5 * linear.sizes[i];
    mean[i] = mean_error(p, c, i, scratch, worst);
    largest = max(largest, worst);
    farthest = max(farthest, worst - abs(mean[i]) + abs(mean[i] - p.center_mean[c]));
  }
  if (p.biased) add_channel(b, scratch, p.coordinates * (2 + p.encoders) + c, b.fresh && at == 0, mean);
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

/// Computes all channels of one coordinate at `depth` vectors of instants from `at`.
template <class Wanted, class L>
[[gnu::always_inline]] inline void add_coordinate(const PathErrorPlan& p, const PathErrorBatch& b,
                                                  std::size_t c, std::size_t at, bool unbounded,
                                                  const ErrorScratch<L>& scratch) {
  const auto row = static_cast<std::size_t>(p.rows[c]);
  L exact[depth];
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) exact[i] = scratch.pose[depth * row + i];
  add_channel(b, scratch, c, b.fresh && at == 0, exact);
  if (b.tally) add_peak(*b.tally, c, exact);
  const bool bounded = !unbounded || row < 6;
  const Linear<L> linear = bounded ? linear_errors<true, Wanted>(p, b, c, at, scratch)
                                   : linear_errors<false, Wanted>(p, b, c, at, scratch);
  add_linear<Wanted>(p, b, c, at, scratch, linear);
  bound_errors(p, b, c, at, linear, scratch);
}

template <class Wanted, class L>
[[gnu::noinline]] void add_coordinates(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                       const ErrorScratch<L>& scratch) {
  const bool unbounded = any_unbounded(p, scratch);
  for (std::size_t c = 0; c < p.coordinates; ++c) add_coordinate<Wanted>(p, b, c, at, unbounded, scratch);
}

/// Computes the bounds only.
template <class L>
[[gnu::noinline]] void bound_coordinates(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                         const ErrorScratch<L>& scratch) {
  for (std::size_t c = 0; c < p.coordinates; ++c) {
    Linear<L> linear{};
    for (std::size_t e = 0; e < p.encoders; ++e) {
      const L* const column = column_of(scratch, e) + p.rows[c];
#pragma GCC unroll 4
      for (std::size_t i = 0; i < depth; ++i) linear.sizes[i] += abs(column[i * next_vector(scratch)]);
    }
    bound_errors(p, b, c, at, linear, scratch);
  }
}

/// Errors of a batch of instants: exact pose error, and linear errors J e of the encoders
/// (operational_error).
template <class L>
void errors(const PathErrorPlan& p, const PathErrorBatch& b) {
  constexpr auto lanes = lane_count<L>;
  const ErrorScratch<L> scratch = scratch_of<L>(p, b.scratch);
  begin_errors(p, scratch);
  const bool tally_only = b.tally && !b.rows;
  auto* const add = b.bounds_only ? bound_coordinates<L>
                    : tally_only  ? b.each ? add_coordinates<Wanted<false, true>, L>
                                           : add_coordinates<Wanted<false, false>, L>
                     : b.each ? add_coordinates<Wanted<true, true>, L>
                                  : add_coordinates<Wanted<true, false>, L>;
  for (std::size_t at = 0; at < batch_size; at += depth * lanes) {
    for (std::size_t i = 0; i < depth; ++i) move_tip(p, b, at + i * lanes, i, scratch);
    add(p, b, at, scratch);
    for (std::size_t i = 0; b.rows && i < depth; ++i)
      into_rows<L>(reinterpret_cast<const double*>(scratch.channels + i), depth * lanes, p.width,
                   b.rows + (at + i * lanes) * p.width);
  }
}

}  // namespace

}  // namespace qerr::lanes
