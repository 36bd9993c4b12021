#pragma once

#include "kinematics/euler_rates.hpp"
#include "lanes/batch.hpp"
#include "simulate/lane_pose_error.hpp"

namespace qerr::lanes {
namespace {

/// Vectors of instants whose errors are worked out at a time: their sums over the encoders, and the sums over
/// these instants, stay in registers.
constexpr std::size_t depth = 4;

/// What the kernel works in: chains and channels may be of any number.
template <class L>
struct ErrorRoom {
  SineCosine<L>* moved;      // [moving joint]
  JointScratch<L>* columns;  // [depth][columns]: of the joints, then of errors that have one of their own
  std::size_t columns_each;  // of a vector of instants
  std::size_t* column_at;    // [error]: vectors from the first column to the error's
  L* missed;                 // [encoder][depth]: its error over its resolution
  L* pose;                   // [9][depth]: error of the pose
  L* channels;               // [width][depth]; behind the last channel they stay 0
  Bits<L>* unbounded;        // [depth]: where roll and yaw have no bounded rate

  JointScratch<L>* joints(std::size_t i) const { return columns + i * columns_each; }
};

inline std::size_t joints_of(const PathErrorPlan& p) {
  return p.chain.count > p.built.count ? p.chain.count : p.built.count;
}

/// Whether errors have columns besides those of the joints.
inline bool own_columns(const PathErrorPlan& p) { return p.mixed || p.angles || p.sources > 0; }

inline std::size_t columns_of(const PathErrorPlan& p) {
  return joints_of(p) + (own_columns(p) ? p.encoders + p.sources : 0);
}

template <class L>
std::size_t errors_room(const PathErrorPlan& p) {
  return joints_of(p) * (sizeof(SineCosine<L>) / sizeof(double)) +
         depth * columns_of(p) * (sizeof(JointScratch<L>) / sizeof(double)) +
         depth * (p.encoders + 9 + p.width + 1) * lane_count<L> + p.encoders + p.sources;
}

template <class L>
ErrorRoom<L> furnished(const PathErrorPlan& p, double* room) {
  ErrorRoom<L> r;
  r.moved = reinterpret_cast<SineCosine<L>*>(room);
  r.columns = reinterpret_cast<JointScratch<L>*>(r.moved + joints_of(p));
  r.columns_each = columns_of(p);
  r.missed = reinterpret_cast<L*>(r.columns + depth * r.columns_each);
  r.pose = r.missed + depth * p.encoders;
  r.channels = r.pose + depth * 9;
  r.unbounded = reinterpret_cast<Bits<L>*>(r.channels + depth * p.width);
  r.column_at = reinterpret_cast<std::size_t*>(r.unbounded + depth);
  return r;
}

/// The rows of an error's column at the first of the vectors of instants, 0..5 of the Jacobian, 6..8 of Euler
/// angles; what is `next_vector` further on is of the next one.
template <class L>
[[gnu::always_inline]] inline L* column_of(const ErrorRoom<L>& room, std::size_t e) {
  return reinterpret_cast<L*>(room.columns) + room.column_at[e];
}

/// From a row of a column to that of the next vector of instants.
template <class L>
[[gnu::always_inline]] inline std::size_t next_vector(const ErrorRoom<L>& room) {
  return room.columns_each * (sizeof(JointScratch<L>) / sizeof(L));
}

/// Columns that are sums of several joints', or another factor of one.
template <class L>
[[gnu::always_inline]] inline void mix_columns(const PathErrorPlan& p, std::size_t i,
                                               const ErrorRoom<L>& room) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const ErrorColumn& column = p.columns[e];
    if ((column.direct && !p.angles) || column.origin) continue;
    L sum[6] = {};
    for (std::size_t k = column.first; k < column.first + column.parts; ++k) {
      const L(&joint)[6] = room.joints(i)[p.parts[k].joint].column;
#pragma GCC unroll 6
      for (int row = 0; row < 6; ++row) sum[row] = fma(p.parts[k].factor, joint[row], sum[row]);
    }
    L* const to = column_of(room, e) + i * next_vector(room);
#pragma GCC unroll 6
    for (int row = 0; row < 6; ++row) to[row] = sum[row];
  }
}

/// Shifts of the origins that stand behind joint `link - 1`.
template <class L>
[[gnu::always_inline]] inline void shift_origins(const PathErrorPlan& p, std::size_t link, const Frame<L>& f,
                                                 std::size_t vector, const ErrorRoom<L>& room) {
  for (std::size_t s = p.encoders; s < p.encoders + p.sources; ++s) {
    const ErrorColumn& source = p.columns[s];
    if (!source.origin || source.link != link) continue;
    const double* d = source.direction;
    L* const to = column_of(room, s) + vector * next_vector(room);
    each_of_three([&](int i) __attribute__((always_inline)) {
      to[i] = fma(d[2], f.z[i], fma(d[1], f.y[i], d[0] * f.x[i]));
      to[3 + i] = L{};
    });
  }
}

/// Rates of the Euler angles along every column.
template <class L>
[[gnu::always_inline]] inline void turn_angles(const PathErrorPlan& p, const Frame<L>& tip, std::size_t i,
                                               const ErrorRoom<L>& room) {
  const EulerRates<L> rates = euler_rates(axes_of(tip, p.chain.tip_axes).x);
  room.unbounded[i] = rates.unbounded;
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    L* const column = column_of(room, e) + i * next_vector(room);
#pragma GCC unroll 3
    for (int angle = 0; angle < 3; ++angle) column[6 + angle] = rates.along(angle, column + 3);
  }
}

template <class L>
[[gnu::always_inline]] inline Frame<L> base_frame() {
  Frame<L> f{};
  f.x[0] = f.y[1] = f.z[2] = broadcast<L>(1);
  return f;
}

/// What is the same at all instants.
template <class L>
void begin_errors(const PathErrorPlan& p, const ErrorRoom<L>& room) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const ErrorColumn& column = p.columns[e];
    const bool joints_own = column.direct && !p.angles;
    room.column_at[e] =
        (joints_own ? p.parts[column.first].joint : joints_of(p) + e) * (sizeof(JointScratch<L>) / sizeof(L));
  }
  for (std::size_t i = 0; i < depth; ++i) {
    prepare_first_joint(p.chain, p.scale, room.joints(i));
    if (p.sources > 0) shift_origins(p, 0, base_frame<L>(), i, room);
  }
}

/// Estimate minus truth of the pose: positions; the rotation vector of R_hat R^T; Euler angles.
///
/// @param near  no joint differs by more than a small turn
template <class L>
[[gnu::always_inline]] inline void pose_error(const PathErrorPlan& p, const Frame<L>& estimate,
                                              const Frame<L>& truth, bool near, L* error) {
  each_of_three([&](std::size_t k)
                    __attribute__((always_inline)) { error[depth * k] = estimate.o[k] - truth.o[k]; });
  if (!p.rotations && !p.angles) return;
  Axes<L> seen, real;
  if (p.as_modelled && !p.angles) {
    // The constant turn behind the last joint drops out of R_hat R^T.
    seen = axes_of(estimate);
    real = axes_of(truth);
  } else {
    seen = axes_of(estimate, p.chain.tip_axes);
    real = axes_of(truth, p.built.tip_axes);
  }
  L three[3];
  if (p.rotations) {
    rotation_vector(seen, real, near && static_cast<double>(p.chain.count) * SmallTurn<L>::largest < 3,
                    three);
    each_of_three([&](std::size_t k) __attribute__((always_inline)) { error[depth * (3 + k)] = three[k]; });
  }
  if (p.angles) {
    roll_pitch_yaw(seen, real, three);
    each_of_three([&](std::size_t k) __attribute__((always_inline)) { error[depth * (6 + k)] = three[k]; });
  }
}

template <class L>
void sines(const FoldedPath& chain, const double* joint, double* to) {
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>, to += chain.count * 2 * lane_count<L>)
    compute_motions(chain, joint + i, batch_size, reinterpret_cast<SineCosine<L>*>(to));
}

/// From the sine and cosine of an angle to those of one that is farther by the angle of this sine, whose
/// cosine is 1 + less.
template <class L, class S>
[[gnu::always_inline]] inline SineCosine<L> turned_on(const SineCosine<L>& a, const S& sine, const S& less) {
  return {fma(a.cosine, sine, fma(a.sine, less, a.sine)), fma(a.cosine, less, a.cosine) - a.sine * sine};
}

/// Joints of one run, from the path that all of them share.
template <class L>
[[gnu::always_inline]] inline void displaced(const FoldedPath& chain, const double* path_sines,
                                             const Displacement* turns, SineCosine<L>* to) {
  const auto* const path = reinterpret_cast<const SineCosine<L>*>(path_sines);
  for (std::size_t k = 0; k < chain.count; ++k) {
    if (chain.joints[k].prismatic)
      to[k].sine = path[k].sine + turns[k].sine;
    else if (chain.joints[k].rotates)
      to[k] = turned_on(path[k], broadcast<L>(turns[k].sine), broadcast<L>(turns[k].less));
  }
}

/// Moves joints on by what encoders miss: from the sine and cosine of an angle to those of one close to it.
///
/// @param moved  at q; at the estimate afterwards, unless it is too far away
/// @returns whether it is not
template <class L>
[[gnu::always_inline]] inline bool move_on(const FoldedPath& chain, const double* q, const double* estimate,
                                           SineCosine<L>* moved) {
  Bits<L> far{};
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    const std::size_t at = joint.coordinate * batch_size;
    const L seen = load<L>(estimate + at), d = joint.multiplier * (seen - load<L>(q + at));
    if (joint.prismatic) {
      moved[k].sine = fma(joint.multiplier, seen, broadcast<L>(joint.offset));
    } else if (joint.rotates) {
      const SmallTurn<L> by(d);
      moved[k] = turned_on(moved[k], by.sine, by.less);
      far |= ~(abs(d) <= SmallTurn<L>::largest);
    }
  }
  return !any<L>(far);
}

/// Columns and error of the pose at the i-th vector of instants, those from `at`.
template <class L>
[[gnu::always_inline]] inline void move_tip(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                            std::size_t i, const ErrorRoom<L>& room) {
  if (b.path_sines)
    displaced(p.chain, b.path_sines + 2 * p.chain.count * at, b.turns, room.moved);
  else
    compute_motions(p.chain, b.joint + at, batch_size, room.moved);
  const Frame<L> modelled = columns_of_motions<L>(
      p.chain, p.scale, room.moved, room.joints(i),
      [&](std::size_t k, const Frame<L>& f) {
        if (p.sources > 0) shift_origins(p, k + 1, f, i, room);
      },
      StoreColumns<L>{room.joints(i)});
  if (p.mixed || p.angles) mix_columns(p, i, room);
  if (p.angles) turn_angles(p, modelled, i, room);
  if (b.bounds_only) return;
  const bool near = move_on(p.chain, b.joint + at, b.estimate + at, room.moved);
  if (!near) compute_motions(p.chain, b.estimate + at, batch_size, room.moved);
  const Frame<L> estimate = walk_motions<L>(p.chain, room.moved, Ignore{}, Ignore{});
  if (p.as_modelled)
    pose_error(p, estimate, modelled, near, room.pose + i);
  else
    pose_error(p, estimate, walk<L>(p.built, b.built_joint + at, batch_size, room.moved, Ignore{}, Ignore{}),
               false, room.pose + i);
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const std::size_t from = e * batch_size + at;
    room.missed[depth * e + i] =
        (load<L>(b.measured + from) - load<L>(b.encoder + from)) * p.per_resolution[e];
  }
}

}  // namespace
}  // namespace qerr::lanes
