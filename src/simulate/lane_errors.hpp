#pragma once

#include "simulate/lane_linear.hpp"
#include "simulate/lane_rows.hpp"

namespace qerr::lanes {
namespace {

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
