#pragma once

#include "bound/kernels.hpp"
#include "kinematics/tip_axes.hpp"
#include "lanes/batch.hpp"

namespace qerr::lanes {

namespace {

constexpr std::size_t most_coordinates = 9;
constexpr double infinity = __builtin_inf();

/// [part][coordinate]: spreads; for a direct model the columns of the joints.
template <class L>
struct Spreads {
  const L* first;
  std::size_t stride;  ///< vectors from one part to the next
  [[gnu::always_inline]] const L* of(std::size_t part) const { return first + part * stride; }
};

/// Scratch memory of the kernel. Frames and spreads are for models that are not direct.
template <class L>
struct Scratch {
  SineCosine<L>* motions;  // [joint]
  JointScratch<L>* joints;
  L* frames;   // [joint][x, y, z][3]
  L* spreads;  // [part][9]

  Scratch(const ErrorPlan& plan, double* memory)
      : motions(reinterpret_cast<SineCosine<L>*>(memory)),
        joints(reinterpret_cast<JointScratch<L>*>(motions + plan.chain.count)),
        frames(reinterpret_cast<L*>(joints + plan.chain.count)),
        spreads(frames + 9 * plan.chain.count) {}
};

/// Doubles of scratch memory.
template <class L>
std::size_t scratch(const ErrorPlan& plan) {
  return plan.chain.count * scratch_per_joint<L> +
         (9 * plan.chain.count + most_coordinates * plan.parts) * lane_count<L>;
}

/// Adds the linear and angular spread of a part.
template <class L>
[[gnu::always_inline]] inline void spread_of(const ErrorPart& part, const Scratch<L>& scratch, L (&u)[6]) {
  for (const JointWeight* w = part.begin; w != part.end; ++w)
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) u[i] = fma(w->weight, scratch.joints[w->joint].column[i], u[i]);
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i) {
      if (part.link > 0)
        u[i] = fma(part.direction[axis], scratch.frames[9 * (part.link - 1) + 3 * axis + i], u[i]);
      else if (axis == i)
        u[i] = u[i] + part.direction[axis];
    }
}

/// Spreads of the parts of a model that is not direct, in the chosen coordinates.
/// @returns lanes at the gimbal lock
template <class L>
Bits<L> gather(const ErrorPlan& plan, const Scratch<L>& scratch, const Frame<L>& tip, double* sums) {
  const Axes<L> axes = axes_of(tip, plan.chain.tip_axes);
  const EulerRates<L> euler = euler_rates(axes.x);
  for (std::size_t p = 0; p < plan.parts; ++p) {
    L u[6] = {};
    spread_of(plan.part[p], scratch, u);
    L* const spread = scratch.spreads + most_coordinates * p;
    for (std::size_t c = 0; c < plan.coordinates; ++c)
      if (plan.coordinate[c] >= 6) spread[c] = euler.along(plan.coordinate[c] - 6, u + 3);
    if (plan.tip_frame) {
      axes.resolve(u);
      axes.resolve(u + 3);
    }
    for (std::size_t c = 0; c < plan.coordinates; ++c)
      if (plan.coordinate[c] < 6) spread[c] = u[plan.coordinate[c]];
  }
  if (!plan.any_euler) return Bits<L>{};
  double* const pitch = sums + plan.sums.pitch * lane_count<L>;
  store(pitch, max(load<L>(pitch), 1.0 - euler.cosine));
  return euler.unbounded;
}

/// A value of a coordinate, infinite for Euler angles at the gimbal lock.
template <class L>
[[gnu::always_inline]] inline L bounded(int coordinate, const Bits<L>& unbounded, const L& value) {
  return coordinate >= 6 ? (unbounded ? broadcast<L>(infinity) : value) : value;
}

/// Columns of the joints and spreads of the parts.
/// @returns lanes at the gimbal lock
template <class L, bool direct>
[[gnu::always_inline]] inline Bits<L> spread(const ErrorPlan& plan, const double* q,
                                             const Scratch<L>& scratch, double* sums) {
  const StoreColumns<L> keep{scratch.joints};
  if constexpr (direct) {
    columns<L>(plan.chain, plan.column_scale, q, batch_size, scratch.motions, scratch.joints, Ignore{}, keep);
    return Bits<L>{};
  } else {
    const auto keep_frame = [&](std::size_t k, const Frame<L>& f) {
#pragma GCC unroll 3
      for (int r = 0; r < 3; ++r) {
        scratch.frames[9 * k + r] = f.x[r];
        scratch.frames[9 * k + 3 + r] = f.y[r];
        scratch.frames[9 * k + 6 + r] = f.z[r];
      }
    };
    const Frame<L> tip = columns<L>(plan.chain, plan.column_scale, q, batch_size, scratch.motions,
                                    scratch.joints, keep_frame, keep);
    return gather(plan, scratch, tip, sums);
  }
}

/// Half width, mean and variance of every coordinate.
template <class L>
struct Errors {
  L half[most_coordinates], mean[most_coordinates], variance[most_coordinates];
};

/// Index of an entry of a symmetric matrix, column <= row.
constexpr std::size_t entry(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }

/// Stores the entries of the covariance as figures of every configuration (keep), or adds them to the sums.
template <class L, bool keep>
struct CovarianceTo {
  static constexpr std::size_t stride = keep ? batch_size : lane_count<L>;
  double* to;

  CovarianceTo(const ErrorPlan& plan, double* figures, double* sums)
      : to(keep ? figures + plan.figures.covariance * batch_size : sums + plan.sums.covariance * stride) {}

  [[gnu::always_inline]] void store_entry(std::size_t e, const L& value) const {
    store(to + e * stride, keep ? value : load<L>(to + e * stride) + value);
  }
};

/// Sums over the parts of three coordinates of a plain model: |u_i| and u_i u_j, which fit in the registers.
template <class L>
struct ThreeSums {
  L a[3] = {}, s[6] = {};

  [[gnu::always_inline]] void add(const L& x, const L& y, const L& z) {
    a[0] += abs(x);
    a[1] += abs(y);
    a[2] += abs(z);
    s[0] = fma(x, x, s[0]);
    s[1] = fma(x, y, s[1]);
    s[2] = fma(y, y, s[2]);
    s[3] = fma(x, z, s[3]);
    s[4] = fma(y, z, s[4]);
    s[5] = fma(z, z, s[5]);
  }

  template <std::size_t from, class To>
  [[gnu::always_inline]] void write(Errors<L>& e, const To& covariance) const {
#pragma GCC unroll 3
    for (std::size_t r = 0; r < 3; ++r) {
      e.half[from + r] = half_width_of_sigma * a[r];
      e.variance[from + r] = s[entry(r, r)];
#pragma GCC unroll 3
      for (std::size_t c = 0; c <= r; ++c) covariance.store_entry(entry(from + r, from + c), s[entry(r, c)]);
    }
  }
};

/// Covariance of positions u and rotations w: sum of w_i u_j over the parts.
///
/// @tparam orthogonal  u . w = 0 in each part, as in the column of a joint: the diagonal sums to 0, so that
/// its third entry follows from two
template <class L, bool orthogonal>
struct MixedSums {
  L s[9] = {};

  [[gnu::always_inline]] void add(const L* u, const L* w) {
#pragma GCC unroll 9
    for (int e = 0; e < (orthogonal ? 8 : 9); ++e) s[e] = fma(w[e / 3], u[e % 3], s[e]);
  }

  template <class To>
  [[gnu::always_inline]] void write(const To& covariance) const {
#pragma GCC unroll 8
    for (std::size_t e = 0; e < 8; ++e) covariance.store_entry(entry(3 + e / 3, e % 3), s[e]);
    covariance.store_entry(entry(5, 2), orthogonal ? -(s[0] + s[4]) : s[8]);
  }
};

template <std::size_t from, class L, class To>
[[gnu::always_inline]] inline void sum_three(const Spreads<L>& spreads, std::size_t parts, Errors<L>& e,
                                             const To& covariance) {
  ThreeSums<L> sums;
  for (std::size_t p = 0; p < parts; ++p) {
    const L* const u = spreads.of(p) + from;
    sums.add(u[0], u[1], u[2]);
  }
  sums.template write<from>(e, covariance);
}

template <bool orthogonal, class L, class To>
[[gnu::always_inline]] inline void sum_mixed(const Spreads<L>& spreads, std::size_t parts,
                                             const To& covariance) {
  MixedSums<L, orthogonal> sums;
  for (std::size_t p = 0; p < parts; ++p) sums.add(spreads.of(p), spreads.of(p) + 3);
  sums.write(covariance);
}

/// Sums for any coordinates and parts.
/// @param unbounded  lanes at the gimbal lock
template <class L, class To>
void sum_any(const ErrorPlan& plan, const Spreads<L>& spreads, const Bits<L>& unbounded, Errors<L>& e,
             const To& covariance) {
  for (std::size_t r = 0; r < plan.coordinates; ++r) {
    e.half[r] = e.mean[r] = L{};
    for (std::size_t p = 0; p < plan.parts; ++p) {
      e.half[r] = fma(plan.part[p].half_width, abs(spreads.of(p)[r]), e.half[r]);
      e.mean[r] = fma(plan.part[p].mean, spreads.of(p)[r], e.mean[r]);
    }
    for (std::size_t c = 0; c <= r; ++c) {
      L sum{};
      for (std::size_t p = 0; p < plan.parts; ++p) {
        const L* const u = spreads.of(p);
        sum = fma((plan.part[p].sigma * plan.part[p].sigma) * u[r], u[c], sum);
      }
      sum = bounded(plan.coordinate[r], unbounded, bounded(plan.coordinate[c], unbounded, sum));
      covariance.store_entry(entry(r, c), sum);
      if (c == r) e.variance[r] = sum;
    }
  }
}

/// Spreads of the parts and all sums over them.
/// @returns lanes in which roll and yaw are unbounded
template <class L, std::size_t fixed, bool direct, class To>
[[gnu::always_inline]] inline Bits<L> sum_parts(const ErrorPlan& plan, const double* q,
                                                const Scratch<L>& scratch, const Spreads<L>& spreads,
                                                Errors<L>& e, const To& covariance, double* sums) {
  const Bits<L> unbounded = spread<L, direct>(plan, q, scratch, sums);
  if constexpr (fixed == 0) {
    sum_any(plan, spreads, unbounded, e, covariance);
  } else {
    sum_three<0>(spreads, plan.moving_parts, e, covariance);
    if constexpr (fixed > 3) {
      sum_three<3>(spreads, plan.parts, e, covariance);
      sum_mixed<direct>(spreads, plan.moving_parts, covariance);
    }
  }
  return unbounded;
}

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

// The templates for plain models with x y z (rx ry rz) save 60 % of the CPU time of `analyze`: 25 instead of
// 64 ns per configuration (Panda, 2e7 Sobol points, one AVX-512 thread of a shared machine) against
// `errors_of<L, 0, false>`. Of that, `direct` saves 46 % against `direct` false (25 instead of 46 ns).
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
