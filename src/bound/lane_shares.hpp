#pragma once

#include "bound/lane_sums.hpp"

namespace qerr::lanes {
namespace {

template <class L>
[[gnu::always_inline]] inline void add_to(double* sum, const L& value) {
  store(sum, load<L>(sum) + value);
}

/// Adds the contribution of each encoder to the variance and its shares of variance and worst case, and
/// updates its largest arm. A coordinate below 1e-13 of the largest sigma is rounding error and has no
/// shares.
template <class L, std::size_t fixed>
[[gnu::always_inline]] inline void add_shares(const ErrorPlan& plan, const Spreads<L>& spreads,
                                              const Errors<L>& total, double* sums) {
  const std::size_t m = fixed > 0 ? fixed : plan.coordinates, row = plan.encoders * lane_count<L>;
  L largest{};
#pragma GCC unroll 6
  for (std::size_t c = 0; c < m; ++c) largest = max(largest, total.variance[c]);
  const L negligible = 1e-26 * largest;
  L over[most_coordinates], over_worst[most_coordinates];
#pragma GCC unroll 6
  for (std::size_t c = 0; c < m; ++c) {
    L width = total.half[c];
    if constexpr (fixed == 0) {
      width = L{};
      for (std::size_t p = 0; p < plan.parts; ++p)
        width = fma(plan.part[p].width, abs(spreads.of(p)[c]), width);
    }
    const L variance = total.variance[c];
    over[c] = variance > negligible ? 1.0 / variance : L{};
    over_worst[c] = width * width > 3.0 * negligible ? 1.0 / width : L{};
  }
  for (std::size_t p = 0; p < plan.parts; ++p) {
    const ErrorPart& part = plan.part[p];
    const L* const u = spreads.of(p);
    double* const of_owner = sums + part.owner * lane_count<L>;
    L arm{};
#pragma GCC unroll 6
    for (std::size_t c = 0; c < m; ++c) {
      const L magnitude = abs(u[c]);
      const L square = fixed > 0 ? u[c] * u[c] : (part.sigma * part.sigma) * (u[c] * u[c]);
      add_to(of_owner + plan.sums.variance_parts * lane_count<L> + c * row, square);
      add_to(of_owner + plan.sums.share * lane_count<L> + c * row, square * over[c]);
      if (fixed == 0 && plan.quantization_parts && !part.source)
        add_to(of_owner + plan.sums.quantization_parts * lane_count<L> + c * row, square);
      add_to(of_owner + plan.sums.worst_share * lane_count<L> + c * row,
             magnitude * (part.width * over_worst[c]));
      if (fixed > 0 ? c < 3 : plan.coordinate[c] < 3) arm = max(arm, magnitude);
    }
    if (part.source) continue;
    double* const arms = of_owner + plan.sums.arms * lane_count<L>;
    store(arms, max(load<L>(arms), plan.arm[part.owner] * arm));
  }
}

/// Stores the figures behind the filters that are not the coordinate's times a norm.
template <class L>
void add_filtered(const ErrorPlan& plan, const Spreads<L>& spreads, const Errors<L>& total,
                  const Bits<L>& unbounded, double* figures, double* sums) {
  const std::size_t m = plan.coordinates;
  for (std::size_t f = 0; f < plan.filters; ++f) {
    for (std::size_t c = 0; c < m; ++c) {
      const auto store_figure = [&](std::size_t figure, const L& value) {
        store(figures + (figure + f * plan.figures.coordinates + c) * batch_size,
              bounded(plan.coordinate[c], unbounded, value));
      };
      const auto spread_behind = [&](const double* squares) {
        L sum{};
        for (std::size_t p = 0; p < plan.parts; ++p) {
          const L u = spreads.of(p)[c];
          sum = fma(squares[f * plan.parts + p], u * u, sum);
        }
        return sqrt(sum);
      };
      if (plan.filtered_worst)
        store_figure(plan.figures.filtered_worst,
                     fma(plan.l1[f], total.half[c], plan.dc_gain[f] * abs(total.mean[c])));
      if (plan.filtered_sigma) store_figure(plan.figures.filtered_sigma, spread_behind(plan.ratio_squares));
      if (plan.motion_squares[f * plan.parts] >= 0)
        store_figure(plan.figures.in_motion, spread_behind(plan.motion_squares));
      if (!plan.filtered_sigma) continue;
      for (std::size_t b = 0; b <= c; ++b) {
        L sum{};
        for (std::size_t p = 0; p < plan.parts; ++p)
          sum = fma(plan.ratio_squares[f * plan.parts + p], spreads.of(p)[c] * spreads.of(p)[b], sum);
        add_to(sums + (plan.sums.filtered + f * entry(m, 0) + entry(c, b)) * lane_count<L>,
               bounded(plan.coordinate[c], unbounded, bounded(plan.coordinate[b], unbounded, sum)));
      }
    }
  }
}

}  // namespace
}  // namespace qerr::lanes
