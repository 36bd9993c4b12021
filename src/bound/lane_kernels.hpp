#pragma once

#include "kernels.hpp"
#include "qerr/bound/bins.hpp"
#include "qerr/core/batch.hpp"
#include "qerr/kinematics/walk.hpp"

namespace qerr::lanes {
namespace {

constexpr std::size_t most_coordinates = 9;
constexpr double infinity = __builtin_inf();
constexpr double half_width_of_sigma = 0x1.bb67ae8584caap+0;  // sqrt(3): of a uniform error

/// How the coordinates move with a part; of a plain, direct model the columns of the joints themselves.
template <class L>
struct Spreads {
  const L* first;
  std::size_t stride;  ///< lanes from one part to the next
  [[gnu::always_inline]] const L* of(std::size_t part) const { return first + part * stride; }
};

/// Room of the kernel: motions, joints, then spreads and frames of models that are not plain.
template <class L>
struct Room {
  SineCosine<L>* moved;
  JointRoom<L>* joints;
  L* frames;   // [joint][x, y, z][3]
  L* spreads;  // [part][9]

  Room(const ErrorPlan& plan, double* room)
      : moved(reinterpret_cast<SineCosine<L>*>(room)),
        joints(reinterpret_cast<JointRoom<L>*>(moved + plan.chain.count)),
        frames(reinterpret_cast<L*>(joints + plan.chain.count)),
        spreads(frames + 9 * plan.chain.count) {}
};

template <class L>
std::size_t room(const ErrorPlan& plan) {
  return plan.chain.count * room_per_joint<L> +
         (9 * plan.chain.count + most_coordinates * plan.parts) * lane_count<L>;
}

/// Rates of roll, pitch and yaw per unit of angular velocity, from the tip's x axis (coordinates.cpp).
template <class L>
struct EulerRates {
  L cosine, over_cosine, cos_yaw, sin_yaw, tan_pitch;
  Bits<L> locked;

  EulerRates(const FoldedPath& chain, const Frame<L>& tip) {
    L x[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i)
      x[i] = fma(chain.tip_axes[0], tip.x[i], fma(chain.tip_axes[1], tip.y[i], chain.tip_axes[2] * tip.z[i]));
    cosine = sqrt(fma(x[0], x[0], x[1] * x[1]));
    locked = cosine < 1e-12;
    over_cosine = 1.0 / (locked ? broadcast<L>(1) : cosine);
    cos_yaw = x[0] * over_cosine;
    sin_yaw = x[1] * over_cosine;
    tan_pitch = -x[2] * over_cosine;
  }

  L row(int coordinate, const L* w) const {
    const L forward = fma(cos_yaw, w[0], sin_yaw * w[1]);
    if (coordinate == 6) return locked ? L{} : forward * over_cosine;
    if (coordinate == 7) return fma(cos_yaw, w[1], -(sin_yaw * w[0]));
    return locked ? L{} : fma(tan_pitch, forward, w[2]);
  }
};

/// Spreads of a part, given how the tip moves with it.
template <class L>
[[gnu::always_inline]] inline void spread_of(const ErrorPart& part, const Room<L>& room, L (&u)[6]) {
  for (const JointWeight* w = part.begin; w != part.end; ++w)
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) u[i] = fma(w->weight, room.joints[w->joint].column[i], u[i]);
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i) {
      if (part.link > 0)
        u[i] = fma(part.direction[axis], room.frames[9 * (part.link - 1) + 3 * axis + i], u[i]);
      else if (axis == i)
        u[i] = u[i] + part.direction[axis];
    }
}

/// Spreads of parts that move by several columns, or by a displaced origin, or in other coordinates.
/// @returns where roll and yaw have no bound
template <class L>
Bits<L> gather(const ErrorPlan& plan, const Room<L>& room, const Frame<L>& tip, double* sums) {
  const EulerRates<L> euler(plan.chain, tip);
  for (std::size_t p = 0; p < plan.parts; ++p) {
    L u[6] = {};
    spread_of(plan.part[p], room, u);
    L* const spread = room.spreads + most_coordinates * p;
    for (std::size_t c = 0; c < plan.coordinates; ++c)
      spread[c] = plan.coordinate[c] < 6 ? u[plan.coordinate[c]] : euler.row(plan.coordinate[c], u + 3);
  }
  if (!plan.any_euler) return Bits<L>{};
  double* const pitch = sums + plan.sums.pitch * lane_count<L>;
  store(pitch, max(load<L>(pitch), 1.0 - euler.cosine));
  return euler.locked;
}

/// What one configuration per lane gives before it is put into figures and sums.
template <class L>
struct Errors {
  L half[most_coordinates], mean[most_coordinates], variance[most_coordinates];
};

constexpr std::size_t entry(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }

/// Where the entries of the covariance go: kept of every configuration, or added to the sum.
template <class L>
struct CovarianceTo {
  double* to;
  std::size_t stride;
  bool add;

  CovarianceTo(const ErrorPlan& plan, double* figures, double* sums)
      : to(plan.keep_covariance ? figures + plan.figures.covariance * batch_size
                                : sums + plan.sums.covariance * lane_count<L>),
        stride(plan.keep_covariance ? batch_size : lane_count<L>),
        add(!plan.keep_covariance) {}

  [[gnu::always_inline]] void put(std::size_t e, const L& value) const {
    store(to + e * stride, add ? load<L>(to + e * stride) + value : value);
  }
};

/// Three coordinates of a plain model: what a processor's registers hold at once.
template <std::size_t from, class L>
[[gnu::always_inline]] inline void sum_three(const Spreads<L>& spreads, std::size_t parts, Errors<L>& e,
                                             const CovarianceTo<L>& covariance) {
  L a[3] = {}, s[6] = {};
  for (std::size_t p = 0; p < parts; ++p) {
    const L* const u = spreads.of(p) + from;
    const L x = u[0], y = u[1], z = u[2];
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
#pragma GCC unroll 3
  for (std::size_t r = 0; r < 3; ++r) {
    e.half[from + r] = half_width_of_sigma * a[r];
    e.variance[from + r] = s[entry(r, r)];
#pragma GCC unroll 3
    for (std::size_t c = 0; c <= r; ++c) covariance.put(entry(from + r, from + c), s[entry(r, c)]);
  }
}

/// Covariance of positions and rotations.
template <class L>
[[gnu::always_inline]] inline void sum_mixed(const Spreads<L>& spreads, std::size_t parts,
                                             const CovarianceTo<L>& covariance) {
  L s[9] = {};
  for (std::size_t p = 0; p < parts; ++p) {
    const L* const u = spreads.of(p);
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r)
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c) s[3 * r + c] = fma(u[3 + r], u[c], s[3 * r + c]);
  }
#pragma GCC unroll 3
  for (std::size_t r = 0; r < 3; ++r)
#pragma GCC unroll 3
    for (std::size_t c = 0; c < 3; ++c) covariance.put(entry(3 + r, c), s[3 * r + c]);
}

/// Any coordinates and parts.
template <class L>
void sum_any(const ErrorPlan& plan, const Spreads<L>& spreads, Errors<L>& e,
             const CovarianceTo<L>& covariance) {
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
      covariance.put(entry(r, c), sum);
      if (c == r) e.variance[r] = sum;
    }
  }
}

/// rho of the position's rigorous bound (operational_error.hpp).
template <class L>
[[gnu::always_inline]] inline L position_remainder(const ErrorPlan& plan, const JointRoom<L>* joints) {
  L rho = broadcast<L>(plan.remainder);
  for (std::size_t k = 0; k < plan.chain.count; ++k) {
    const L(&u)[6] = joints[k].column;
    rho = fma(plan.reach[k], sqrt(fma(u[0], u[0], fma(u[1], u[1], u[2] * u[2]))), rho);
  }
  return rho;
}

template <class L>
[[gnu::always_inline]] inline void add_to(double* sum, const L& value) {
  store(sum, load<L>(sum) + value);
}

/// What each encoder contributes: to the variance, to the coordinates' shares of it and of the worst case,
/// and its largest arm. A coordinate that is nothing but rounding against the largest has no shares.
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
    double* const at = sums + part.owner * lane_count<L>;
    L arm{};
#pragma GCC unroll 6
    for (std::size_t c = 0; c < m; ++c) {
      const L magnitude = abs(u[c]);
      const L square = fixed > 0 ? u[c] * u[c] : (part.sigma * part.sigma) * (u[c] * u[c]);
      add_to(at + plan.sums.variance_parts * lane_count<L> + c * row, square);
      add_to(at + plan.sums.share * lane_count<L> + c * row, square * over[c]);
      add_to(at + plan.sums.worst_share * lane_count<L> + c * row, magnitude * (part.width * over_worst[c]));
      if (fixed > 0 ? c < 3 : plan.coordinate[c] < 3) arm = max(arm, magnitude);
    }
    if (part.source) continue;
    double* const arms = at + plan.sums.arms * lane_count<L>;
    store(arms, max(load<L>(arms), plan.arm[part.owner] * arm));
  }
}

/// Figures behind the filters where they are not the coordinate's times a norm.
template <class L>
void add_filtered(const ErrorPlan& plan, const Spreads<L>& spreads, const Errors<L>& total,
                  const Bits<L>& locked, double* figures, double* sums) {
  const std::size_t m = plan.coordinates;
  for (std::size_t f = 0; f < plan.filters; ++f) {
    for (std::size_t c = 0; c < m; ++c) {
      const L bound =
          plan.coordinate[c] == 6 || plan.coordinate[c] == 8 ? (locked ? broadcast<L>(infinity) : L{}) : L{};
      const auto put = [&](std::size_t figure, const L& value) {
        store(figures + (figure + f * m + c) * batch_size, bound > 0 ? bound : value);
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
        put(plan.figures.filtered_worst,
            fma(plan.l1[f], total.half[c], plan.dc_gain[f] * abs(total.mean[c])));
      if (plan.filtered_sigma) put(plan.figures.filtered_sigma, spread_behind(plan.gain_squares));
      if (plan.motion_squares[f * plan.parts] >= 0)
        put(plan.figures.in_motion, spread_behind(plan.motion_squares));
      if (!plan.filtered_sigma) continue;
      for (std::size_t b = 0; b <= c; ++b) {
        L sum{};
        for (std::size_t p = 0; p < plan.parts; ++p)
          sum = fma(plan.gain_squares[f * plan.parts + p], spreads.of(p)[c] * spreads.of(p)[b], sum);
        add_to(sums + (plan.sums.filtered + f * entry(m, 0) + entry(c, b)) * lane_count<L>, sum);
      }
    }
  }
}

/// The sums of `sum_three<0>` and `sum_mixed`, taken as the columns come: they need not be read again, where
/// a processor has registers for all of them.
template <class L>
struct RunningSums {
  static constexpr bool fit = lane_count<L> == 8;  // 32 registers
  L a[3] = {}, s[6] = {}, x[9] = {};

  [[gnu::always_inline]] void add(const L (&u)[3], const L (&w)[3]) {
    a[0] += abs(u[0]);
    a[1] += abs(u[1]);
    a[2] += abs(u[2]);
    s[0] = fma(u[0], u[0], s[0]);
    s[1] = fma(u[0], u[1], s[1]);
    s[2] = fma(u[1], u[1], s[2]);
    s[3] = fma(u[0], u[2], s[3]);
    s[4] = fma(u[1], u[2], s[4]);
    s[5] = fma(u[2], u[2], s[5]);
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r)
#pragma GCC unroll 3
      for (int c = 0; c < 3; ++c) x[3 * r + c] = fma(w[r], u[c], x[3 * r + c]);
  }

  [[gnu::always_inline]] void put(Errors<L>& e, const CovarianceTo<L>& covariance) const {
#pragma GCC unroll 3
    for (std::size_t r = 0; r < 3; ++r) {
      e.half[r] = half_width_of_sigma * a[r];
      e.variance[r] = s[entry(r, r)];
#pragma GCC unroll 3
      for (std::size_t c = 0; c <= r; ++c) covariance.put(entry(r, c), s[entry(r, c)]);
#pragma GCC unroll 3
      for (std::size_t c = 0; c < 3; ++c) covariance.put(entry(3 + r, c), x[3 * r + c]);
    }
  }
};

/// Columns of the joints, and how the coordinates move with every part.
/// @returns where roll and yaw have no bound
template <class L, bool direct>
[[gnu::always_inline]] inline Bits<L> spread(const ErrorPlan& plan, const double* q, const Room<L>& room,
                                             double* sums) {
  const KeepColumns<L> give{room.joints};
  if constexpr (direct) {
    columns<L>(plan.chain, plan.column_scale, q, batch_size, room.moved, room.joints, PassBy{}, give);
    return Bits<L>{};
  } else {
    const auto leave = [&](std::size_t k, const Frame<L>& f) {
#pragma GCC unroll 3
      for (int r = 0; r < 3; ++r) {
        room.frames[9 * k + r] = f.x[r];
        room.frames[9 * k + 3 + r] = f.y[r];
        room.frames[9 * k + 6 + r] = f.z[r];
      }
    };
    const Frame<L> tip =
        columns<L>(plan.chain, plan.column_scale, q, batch_size, room.moved, room.joints, leave, give);
    return gather(plan, room, tip, sums);
  }
}

template <class L, std::size_t fixed, bool direct>
void errors_of(const ErrorPlan& plan, const double* q, double* figures, double* sums, double* memory) {
  const Room<L> room(plan, memory);
  const std::size_t m = fixed > 0 ? fixed : plan.coordinates;
  const Spreads<L> spreads = direct ? Spreads<L>{room.joints->column, sizeof(JointRoom<L>) / sizeof(L)}
                                    : Spreads<L>{room.spreads, most_coordinates};
  begin_columns(plan.chain, plan.column_scale, room.joints);
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    double* const to = figures + i;
    const CovarianceTo<L> covariance(plan, to, sums);
    Errors<L> e;
    Bits<L> locked{};
    constexpr bool fused = direct && fixed == 6 && RunningSums<L>::fit;
    if constexpr (fused) {
      RunningSums<L> running;
      const KeepColumns<L> keep{room.joints};
      columns<L>(plan.chain, plan.column_scale, q + i, batch_size, room.moved, room.joints, PassBy{},
                 [&](std::size_t k, const L(&linear)[3], const L(&angular)[3]) {
                   if (plan.columns_again) keep(k, linear, angular);
                   if (k < plan.moving_parts) running.add(linear, angular);
                 });
      running.put(e, covariance);
      sum_three<3>(spreads, plan.parts, e, covariance);
    } else {
      locked = spread<L, direct>(plan, q + i, room, sums);
    }
    if constexpr (fused) {
    } else if constexpr (fixed > 0) {
      sum_three<0>(spreads, plan.moving_parts, e, covariance);
      if constexpr (fixed > 3) {
        sum_three<3>(spreads, plan.parts, e, covariance);
        sum_mixed(spreads, plan.moving_parts, covariance);
      }
    } else {
      sum_any(plan, spreads, e, covariance);
    }
    const L rho = plan.rigorous ? position_remainder(plan, room.joints) : L{};
    L trace{};
#pragma GCC unroll 6
    for (std::size_t c = 0; c < m; ++c) {
      const int coordinate = fixed > 0 ? static_cast<int>(c) : plan.coordinate[c];
      L worst = e.half[c];
      if constexpr (fixed == 0) {
        worst += abs(e.mean[c]);
        if (coordinate == 6 || coordinate == 8) {
          worst = locked ? broadcast<L>(infinity) : worst;
          e.variance[c] = locked ? broadcast<L>(infinity) : e.variance[c];
        }
      }
      store(to + (plan.figures.worst_case + c) * batch_size, worst);
      if (!plan.keep_covariance) store(to + (plan.figures.sigma + c) * batch_size, sqrt(e.variance[c]));
      if (coordinate < 3 || !plan.any_position) trace += e.variance[c];
      if (!plan.rigorous) continue;
      store(to + (plan.figures.rigorous + c) * batch_size,
            coordinate < 3   ? worst + rho
            : coordinate < 6 ? min(worst + plan.angle_remainder, broadcast<L>(plan.angle))
                             : broadcast<L>(infinity));
    }
    if (plan.shares) {
      store(to + plan.figures.trace * batch_size, trace);
      add_shares<L, fixed>(plan, spreads, e, sums);
    }
    if (plan.filters > 0) add_filtered(plan, spreads, e, locked, to, sums);
  }
}

template <class L>
void errors(const ErrorPlan& plan, const double* q, double* figures, double* sums, double* room) {
  if (!plan.plain || !plan.positions_first)
    errors_of<L, 0, false>(plan, q, figures, sums, room);
  else if (plan.coordinates == 3)
    (plan.direct ? errors_of<L, 3, true> : errors_of<L, 3, false>)(plan, q, figures, sums, room);
  else
    (plan.direct ? errors_of<L, 6, true> : errors_of<L, 6, false>)(plan, q, figures, sums, room);
}

/// A batch with a maximum larger than before: looks for the configurations.
[[gnu::noinline]] inline void find_maxima(const double* figures, std::size_t count, std::uint64_t first,
                                          Tally* tallies) {
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    double most = t.max;
    for (std::size_t i = 0; i < batch_size; ++i) most = values[i] > most ? values[i] : most;
    const bool is_another = most > same_maximum * t.max;
    t.max = most;
    for (std::size_t i = 0; i < batch_size && is_another; ++i)
      if (values[i] * same_maximum >= most) {
        t.at_max = first + i;
        break;
      }
  }
}

template <class L>
void tally(const double* figures, std::size_t count, std::uint64_t first, Tally* tallies) {
  Bits<L> news{};
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    L low = load<L>(t.min), high = broadcast<L>(t.max), sum = load<L>(t.sum);
    const L most = high;
#pragma GCC unroll 32
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      const L value = load<L>(values + i);
      low = min(low, value);
      high = max(high, value);
      sum += value;
    }
    store(t.sum, sum);
    store(t.min, low);
    news |= high > most;
  }
  std::int64_t any = 0;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) any |= news[i];
  if (any) find_maxima(figures, count, first, tallies);  // rare
}

/// Eight at a time whatever the lanes: of a double's bits the upper half is enough, and 32-bit numbers have
/// minima and maxima on every instruction set.
void bins(const double* figures, std::size_t count, const std::int64_t* lowest, std::uint16_t* keys,
          std::size_t stride) {
  typedef std::int32_t Halves __attribute__((vector_size(64)));
  typedef std::int32_t Bins __attribute__((vector_size(32)));
  typedef std::uint16_t Narrow __attribute__((vector_size(16)));
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  for (std::size_t f = 0; f < count; ++f)
#pragma GCC unroll 4
    for (std::size_t i = 0; i < batch_size; i += 8) {
      Halves halves;
      __builtin_memcpy(&halves, figures + f * batch_size + i, sizeof halves);
      Bins bin = __builtin_shufflevector(halves, halves, 1, 3, 5, 7, 9, 11, 13, 15) >> (bin_shift - 32);
      bin -= static_cast<std::int32_t>(lowest[f]);
      bin = bin < 0 ? Bins{} : bin;
      bin = bin > static_cast<std::int32_t>(last_bin) ? Bins{} + static_cast<std::int32_t>(last_bin) : bin;
      const auto narrow = __builtin_convertvector(bin, Narrow);
      __builtin_memcpy(keys + f * stride + i, &narrow, sizeof narrow);
    }
}

template <int n>
constexpr BoundKernels bound_kernels{n, room<Lanes<n>>, errors<Lanes<n>>, tally<Lanes<n>>, bins};

}  // namespace
}  // namespace qerr::lanes
