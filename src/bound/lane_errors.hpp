#pragma once

#include "bound/kernels.hpp"
#include "bound/lane_sums.hpp"

// The templates for plain models with x y z (rx ry rz) save 60 % of the CPU time of `analyze`: 25 instead of
// 64 ns per configuration (Panda, 2e7 Sobol points, one AVX-512 thread of a shared machine) against
// `errors_of<L, 0, false>`. Of that, `direct` saves 46 % against `direct` false (25 instead of 46 ns).

namespace qerr::lanes {
namespace {

/// Stores worst case, sigma and rigorous bound of every coordinate.
template <class L, std::size_t fixed, bool keep_covariance>
[[gnu::always_inline]] inline void store_figures(const ErrorPlan& plan, const Scratch<L>& scratch,
                                                 Errors<L>& e, const Bits<L>& unbounded, double* to) {
  const std::size_t m = fixed > 0 ? fixed : plan.coordinates;
  const L rho = plan.rigorous
                    ? plan.remainder + weighted_column_norms(plan.chain, plan.per_column, scratch.joints)
                    : L{};
  L trace{};
#pragma GCC unroll 6
  for (std::size_t c = 0; c < m; ++c) {
    const int coordinate = fixed > 0 ? static_cast<int>(c) : plan.coordinate[c];
    L worst = e.half[c];
    if constexpr (fixed == 0) {
      worst = bounded(coordinate, unbounded, worst + abs(e.mean[c]));
    }
    store(to + (plan.figures.worst_case + c) * batch_size, worst);
    if (!keep_covariance) store(to + (plan.figures.sigma + c) * batch_size, sqrt(e.variance[c]));
    if (coordinate < 3 || !plan.any_position) trace += e.variance[c];
    if (!plan.rigorous) continue;
    store(to + (plan.figures.rigorous + c) * batch_size,
          coordinate < 3   ? worst + rho
          : coordinate < 6 ? min(worst + plan.angle_remainder, broadcast<L>(plan.angle))
                           : broadcast<L>(infinity));
  }
  if (plan.shares) store(to + plan.figures.trace * batch_size, trace);
}

/// @tparam fixed            coordinates of a plain model: 3 for x y z, 6 for x y z rx ry rz; 0: any model
/// @tparam direct           ErrorPlan::direct
/// @tparam keep_covariance  ErrorPlan::keep_covariance
template <class L, std::size_t fixed, bool direct, bool keep_covariance>
void errors_of(const ErrorPlan& plan, const double* q, double* figures, double* sums, double* memory) {
  const Scratch<L> scratch(plan, memory);
  const Spreads<L> spreads = direct ? Spreads<L>{scratch.joints->column, sizeof(JointScratch<L>) / sizeof(L)}
                                    : Spreads<L>{scratch.spreads, most_coordinates};
  prepare_first_joint(plan.chain, plan.column_scale, scratch.joints);
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    double* const to = figures + i;
    const CovarianceTo<L, keep_covariance> covariance(plan, to, sums);
    Errors<L> e{};
    const Bits<L> unbounded = sum_parts<L, fixed, direct>(plan, q + i, scratch, spreads, e, covariance, sums);
    store_figures<L, fixed, keep_covariance>(plan, scratch, e, unbounded, to);
    if (plan.shares) add_shares<L, fixed>(plan, spreads, e, sums);
    if (plan.filters > 0) {
      Errors<L> copy;  // `e` itself stays in registers, as no call takes its address
#pragma GCC unroll 9
      for (std::size_t c = 0; c < most_coordinates; ++c) {
        copy.half[c] = e.half[c];
        copy.mean[c] = e.mean[c];
      }
      add_filtered(plan, spreads, copy, unbounded, to, sums);
    }
  }
}

template <class L, bool keep_covariance>
[[gnu::always_inline]] inline auto errors_by(const ErrorPlan& plan) {
  if (!plan.plain || !plan.positions_first) return errors_of<L, 0, false, keep_covariance>;
  if (plan.coordinates == 3)
    return plan.direct ? errors_of<L, 3, true, keep_covariance> : errors_of<L, 3, false, keep_covariance>;
  return plan.direct ? errors_of<L, 6, true, keep_covariance> : errors_of<L, 6, false, keep_covariance>;
}

template <class L>
void errors(const ErrorPlan& plan, const double* q, double* figures, double* sums, double* scratch) {
  (plan.keep_covariance ? errors_by<L, true>(plan) : errors_by<L, false>(plan))(plan, q, figures, sums,
                                                                                scratch);
}

}  // namespace
}  // namespace qerr::lanes
