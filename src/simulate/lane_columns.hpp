#pragma once

#include "kinematics/tip_axes.hpp"
#include "lanes/batch.hpp"
#include "simulate/kernels.hpp"

namespace qerr::lanes {

namespace {

/// Whether a comparison holds in any lane.
template <class L>
[[gnu::always_inline]] inline bool any(const Bits<L>& mask) {
  if constexpr (lane_count<L> == 8) {
    return any<Lanes<4>>(__builtin_shufflevector(mask, mask, 0, 1, 2, 3) |
                         __builtin_shufflevector(mask, mask, 4, 5, 6, 7));
  } else if constexpr (lane_count<L> == 4) {
    return any<Lanes<2>>(__builtin_shufflevector(mask, mask, 0, 1) |
                         __builtin_shufflevector(mask, mask, 2, 3));
  } else {
    return (mask[0] | mask[1]) != 0;
  }
}

/// Range of the series below in sine and tangent, in which 7 terms are accurate to double precision.
constexpr double small_angle = 0x1p-4;

/// asin(s)/s as a function of s^2, |s| <= small_angle.
template <class L>
[[gnu::always_inline]] inline L arc_of_sine(const L& s2) {
  L sum = broadcast<L>(231.0 / 13312);
#pragma GCC unroll 6
  for (const double c : {63.0 / 2816, 35.0 / 1152, 5.0 / 112, 3.0 / 40, 1.0 / 6, 1.0})
    sum = fma(sum, s2, broadcast<L>(c));
  return sum;
}

/// Range of the series in the sine in which four terms are accurate to double precision.
constexpr double tiny_sine = 0x1p-9;

/// x/sin(x) from sin(x)^2 and cos(x).
template <class L>
[[gnu::noinline]] L arc_over_sine(const L& sine2, const L& cosine) {
  L factor = arc_of_sine(sine2);
  const Bits<L> large = ~((sine2 <= small_angle * small_angle) & (cosine > 0));
  if (any<L>(large)) {
    for (std::size_t i = 0; i < lane_count<L>; ++i) {
      const double sine = __builtin_sqrt(sine2[i]);
      if (large[i]) factor[i] = sine < 1e-300 ? 0 : __builtin_atan2(sine, cosine[i]) / sine;
    }
  }
  return factor;
}

/// atan(t)/t as a function of t^2, |t| <= small_angle.
template <class L>
[[gnu::always_inline]] inline L arc_of_tangent(const L& t2) {
  L sum = broadcast<L>(1.0 / 13);
#pragma GCC unroll 6
  for (const double c : {-1.0 / 11, 1.0 / 9, -1.0 / 7, 1.0 / 5, -1.0 / 3, 1.0})
    sum = fma(sum, t2, broadcast<L>(c));
  return sum;
}

template <class L>
[[gnu::always_inline]] inline L dot(const L (&a)[3], const L (&b)[3]) {
  return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]));
}

/// The rotation vector of R_hat R^T (tip_error): its axis from the antisymmetric part, which is the sum of
/// the cross products of true and estimated axes.
///
/// @param near  its length is known to be below 3
template <class L>
[[gnu::always_inline]] inline void rotation_vector(const Axes<L>& estimate, const Axes<L>& truth, bool near,
                                                   L (&vector)[3]) {
  L x[3], y[3], z[3];
  cross(truth.x, estimate.x, x);
  cross(truth.y, estimate.y, y);
  cross(truth.z, estimate.z, z);
  each_of_three([&](int i) __attribute__((always_inline)) { vector[i] = x[i] + y[i] + z[i]; });
  const L square = dot(vector, vector);  // (2 sin)^2
  // Errors of encoders are small angles: half of the first terms of `arc_of_sine`.
  L factor = broadcast<L>(5.0 / 14336);
#pragma GCC unroll 3
  for (const double c : {3.0 / 1280, 1.0 / 48, 1.0 / 2}) factor = fma(factor, square, broadcast<L>(c));
  if (!near || any<L>(~(square <= 4 * tiny_sine * tiny_sine))) {
    const L trace = dot(truth.x, estimate.x) + dot(truth.y, estimate.y) + dot(truth.z, estimate.z);
    factor = 0.5 * arc_over_sine<L>(0.25 * square, 0.5 * (trace - 1));
  }
  each_of_three([&](int i) __attribute__((always_inline)) { vector[i] *= factor; });
}

/// The angle from (bx, by) to (ax, ay), in [-pi, pi].
template <class L>
[[gnu::always_inline]] inline L angle_between(const L& ay, const L& ax, const L& by, const L& bx) {
  const L along = fma(ax, bx, ay * by), tangent = fma(ay, bx, -(ax * by)) / along;
  L angle = tangent * arc_of_tangent(tangent * tangent);
  const Bits<L> large = ~((along > 0) & (abs(tangent) <= small_angle));
  if (any<L>(large)) {
    for (std::size_t i = 0; i < lane_count<L>; ++i)
      if (large[i])
        angle[i] = __builtin_remainder(__builtin_atan2(ay[i], ax[i]) - __builtin_atan2(by[i], bx[i]),
                                       6.283185307179586);
  }
  return angle;
}

template <class L>
[[gnu::always_inline]] inline L cosine_of_pitch(const Axes<L>& a) {
  return sqrt(fma(a.x[0], a.x[0], a.x[1] * a.x[1]));
}

/// Roll, pitch and yaw, estimate minus truth.
template <class L>
[[gnu::always_inline]] inline void roll_pitch_yaw(const Axes<L>& a, const Axes<L>& b, L (&angles)[3]) {
  angles[0] = angle_between(a.y[2], a.z[2], b.y[2], b.z[2]);
  angles[1] = angle_between<L>(-a.x[2], cosine_of_pitch(a), -b.x[2], cosine_of_pitch(b));
  angles[2] = angle_between(a.x[1], a.x[0], b.x[1], b.x[0]);
}

/// Vectors of instants that are evaluated together: their sums over the encoders and over the instants stay
/// in registers.
constexpr std::size_t depth = 4;

/// Scratch memory of the kernel, for any number of joints and channels.
template <class L>
struct ErrorScratch {
  SineCosine<L>* moved;      // [moving joint]
  JointScratch<L>* columns;  // [depth][columns]: of the joints, then of errors with own columns
  std::size_t columns_each;  // per vector of instants
  std::size_t* column_at;    // [error]: offset of its column, in vectors
  L* residual_counts;        // [encoder][depth]: error over resolution
  L* pose;                   // [9][depth]: pose error
  L* channels;               // [width][depth]; the padding stays 0
  Bits<L>* unbounded;        // [depth]: whether it is the gimbal lock

  JointScratch<L>* joints(std::size_t i) const { return columns + i * columns_each; }
};

inline std::size_t joints_of(const PathErrorPlan& p) {
  return p.chain.count > p.built.count ? p.chain.count : p.built.count;
}

/// Whether the columns of the joints are changed, and copied for that.
inline bool changes_columns(const PathErrorPlan& p) { return p.angles || p.tip_frame; }

/// Whether errors have other columns than those of the joints.
inline bool own_columns(const PathErrorPlan& p) { return p.mixed || changes_columns(p) || p.sources > 0; }

inline std::size_t columns_of(const PathErrorPlan& p) {
  return joints_of(p) + (own_columns(p) ? p.encoders + p.sources : 0);
}

template <class L>
std::size_t errors_scratch_size(const PathErrorPlan& p) {
  return joints_of(p) * (sizeof(SineCosine<L>) / sizeof(double)) +
         depth * columns_of(p) * (sizeof(JointScratch<L>) / sizeof(double)) +
         depth * (p.encoders + 9 + p.width + 1) * lane_count<L> + p.encoders + p.sources;
}

template <class L>
ErrorScratch<L> scratch_of(const PathErrorPlan& p, double* scratch) {
  ErrorScratch<L> r;
  r.moved = reinterpret_cast<SineCosine<L>*>(scratch);
  r.columns = reinterpret_cast<JointScratch<L>*>(r.moved + joints_of(p));
  r.columns_each = columns_of(p);
  r.residual_counts = reinterpret_cast<L*>(r.columns + depth * r.columns_each);
  r.pose = r.residual_counts + depth * p.encoders;
  r.channels = r.pose + depth * 9;
  r.unbounded = reinterpret_cast<Bits<L>*>(r.channels + depth * p.width);
  r.column_at = reinterpret_cast<std::size_t*>(r.unbounded + depth);
  return r;
}

/// The column of an error at the first vector of instants: rows 0..5 of the Jacobian, 6..8 of Euler angles;
/// that of the next vector is `next_vector` further.
template <class L>
[[gnu::always_inline]] inline L* column_of(const ErrorScratch<L>& scratch, std::size_t e) {
  return reinterpret_cast<L*>(scratch.columns) + scratch.column_at[e];
}

/// Distance from a row of a column to that of the next vector of instants, in vectors.
template <class L>
[[gnu::always_inline]] inline std::size_t next_vector(const ErrorScratch<L>& scratch) {
  return scratch.columns_each * (sizeof(JointScratch<L>) / sizeof(L));
}

/// Computes columns that are weighted sums of columns of joints.
template <class L>
[[gnu::always_inline]] inline void mix_columns(const PathErrorPlan& p, std::size_t i,
                                               const ErrorScratch<L>& scratch) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const ErrorColumn& column = p.columns[e];
    if ((column.direct && !changes_columns(p)) || column.origin) continue;
    L sum[6] = {};
    for (std::size_t k = column.first; k < column.first + column.parts; ++k) {
      const L(&joint)[6] = scratch.joints(i)[p.parts[k].joint].column;
#pragma GCC unroll 6
      for (int row = 0; row < 6; ++row) sum[row] = fma(p.parts[k].factor, joint[row], sum[row]);
    }
    L* const to = column_of(scratch, e) + i * next_vector(scratch);
#pragma GCC unroll 6
    for (int row = 0; row < 6; ++row) to[row] = sum[row];
  }
}

/// Columns of displaced origins after joint `link - 1`.
template <class L>
[[gnu::always_inline]] inline void shift_origins(const PathErrorPlan& p, std::size_t link, const Frame<L>& f,
                                                 std::size_t vector, const ErrorScratch<L>& scratch) {
  for (std::size_t s = p.encoders; s < p.encoders + p.sources; ++s) {
    const ErrorColumn& source = p.columns[s];
    if (!source.origin || source.link != link) continue;
    const double* d = source.direction;
    L* const to = column_of(scratch, s) + vector * next_vector(scratch);
    each_of_three([&](int i) __attribute__((always_inline)) {
      to[i] = fma(d[2], f.z[i], fma(d[1], f.y[i], d[0] * f.x[i]));
      to[3 + i] = L{};
    });
  }
}

/// Columns in the axes of the tip instead of those of the base.
template <class L>
[[gnu::always_inline]] inline void resolve_columns(const PathErrorPlan& p, const Axes<L>& tip, std::size_t i,
                                                   const ErrorScratch<L>& scratch) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    L* const column = column_of(scratch, e) + i * next_vector(scratch);
    tip.resolve(column);
    tip.resolve(column + 3);
  }
}

/// Rates of the Euler angles along every column.
template <class L>
[[gnu::always_inline]] inline void add_angle_rates(const PathErrorPlan& p, const Frame<L>& tip, std::size_t i,
                                                   const ErrorScratch<L>& scratch) {
  const EulerRates<L> rates = euler_rates(axes_of(tip, p.chain.tip_axes).x);
  scratch.unbounded[i] = rates.unbounded;
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    L* const column = column_of(scratch, e) + i * next_vector(scratch);
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

/// Prepares the quantities that are equal at all instants.
template <class L>
void begin_errors(const PathErrorPlan& p, const ErrorScratch<L>& scratch) {
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const ErrorColumn& column = p.columns[e];
    const bool of_joint = column.direct && !changes_columns(p);
    scratch.column_at[e] =
        (of_joint ? p.parts[column.first].joint : joints_of(p) + e) * (sizeof(JointScratch<L>) / sizeof(L));
  }
  for (std::size_t i = 0; i < depth; ++i) {
    prepare_first_joint(p.chain, p.scale, scratch.joints(i));
    if (p.sources > 0) shift_origins(p, 0, base_frame<L>(), i, scratch);
  }
}

/// Pose error, estimate - truth: positions; the rotation vector of R_hat R^T; Euler angles.
///
/// @param near  no joint differs by more than SmallAngle::largest
template <class L>
[[gnu::always_inline]] inline void pose_error(const PathErrorPlan& p, const Frame<L>& estimate,
                                              const Frame<L>& truth, bool near, L* error) {
  L three[3];
  each_of_three([&](std::size_t k) __attribute__((always_inline)) { three[k] = estimate.o[k] - truth.o[k]; });
  if (p.tip_frame) axes_of(truth, p.built.tip_axes).resolve(three);
  each_of_three([&](std::size_t k) __attribute__((always_inline)) { error[depth * k] = three[k]; });
  if (!p.rotations && !p.angles) return;
  Axes<L> estimated_axes, true_axes;
  if (p.as_modelled && !changes_columns(p)) {
    // The constant rotation after the last joint cancels in R_hat R^T.
    estimated_axes = axes_of(estimate);
    true_axes = axes_of(truth);
  } else {
    estimated_axes = axes_of(estimate, p.chain.tip_axes);
    true_axes = axes_of(truth, p.built.tip_axes);
  }
  if (p.rotations) {
    rotation_vector(estimated_axes, true_axes,
                    near && static_cast<double>(p.chain.count) * SmallAngle<L>::largest < 3, three);
    if (p.tip_frame) true_axes.resolve(three);
    each_of_three([&](std::size_t k) __attribute__((always_inline)) { error[depth * (3 + k)] = three[k]; });
  }
  if (p.angles) {
    roll_pitch_yaw(estimated_axes, true_axes, three);
    each_of_three([&](std::size_t k) __attribute__((always_inline)) { error[depth * (6 + k)] = three[k]; });
  }
}

template <class L>
void sines(const FoldedPath& chain, const double* joint, double* to) {
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>, to += chain.count * 2 * lane_count<L>)
    compute_motions(chain, joint + i, batch_size, reinterpret_cast<SineCosine<L>*>(to));
}

/// Sine and cosine of a sum of angles; the second angle is given by its sine and cosine - 1 = `less`.
template <class L, class S>
[[gnu::always_inline]] inline SineCosine<L> rotated(const SineCosine<L>& a, const S& sine, const S& less) {
  return {fma(a.cosine, sine, fma(a.sine, less, a.sine)), fma(a.cosine, less, a.cosine) - a.sine * sine};
}

/// Sines and cosines of the joints of one run, from those of the shared path.
template <class L>
[[gnu::always_inline]] inline void displaced(const FoldedPath& chain, const double* path_sines,
                                             const Displacement* turns, SineCosine<L>* to) {
  const auto* const path = reinterpret_cast<const SineCosine<L>*>(path_sines);
  for (std::size_t k = 0; k < chain.count; ++k) {
    if (chain.joints[k].prismatic)
      to[k].sine = path[k].sine + turns[k].sine;
    else if (chain.joints[k].rotates)
      to[k] = rotated(path[k], broadcast<L>(turns[k].sine), broadcast<L>(turns[k].less));
  }
}

/// Updates sines and cosines from the true to the estimated joint positions.
///
/// @param moved  at q; on return at the estimate, if true is returned
/// @returns whether all differences are at most SmallAngle::largest
template <class L>
[[gnu::always_inline]] inline bool move_to_estimate(const FoldedPath& chain, const double* q,
                                                    const double* estimate, SineCosine<L>* moved) {
  Bits<L> far{};
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    const std::size_t at = joint.coordinate * batch_size;
    const L estimated = load<L>(estimate + at), d = joint.multiplier * (estimated - load<L>(q + at));
    if (joint.prismatic) {
      moved[k].sine = fma(joint.multiplier, estimated, broadcast<L>(joint.offset));
    } else if (joint.rotates) {
      const SmallAngle<L> by(d);
      moved[k] = rotated(moved[k], by.sine, by.less);
      far |= ~(abs(d) <= SmallAngle<L>::largest);
    }
  }
  return !any<L>(far);
}

/// Columns and pose error at the i-th vector of instants, which begins at instant `at`.
template <class L>
[[gnu::always_inline]] inline void move_tip(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                            std::size_t i, const ErrorScratch<L>& scratch) {
  if (b.path_sines)
    displaced(p.chain, b.path_sines + 2 * p.chain.count * at, b.turns, scratch.moved);
  else
    compute_motions(p.chain, b.joint + at, batch_size, scratch.moved);
  if (p.tip_frame && p.sources > 0) shift_origins(p, 0, base_frame<L>(), i, scratch);
  const Frame<L> modelled = columns_of_motions<L>(
      p.chain, p.scale, scratch.moved, scratch.joints(i),
      [&](std::size_t k, const Frame<L>& f) {
        if (p.sources > 0) shift_origins(p, k + 1, f, i, scratch);
      },
      StoreColumns<L>{scratch.joints(i)});
  if (p.mixed || changes_columns(p)) mix_columns(p, i, scratch);
  if (p.angles) add_angle_rates(p, modelled, i, scratch);
  if (p.tip_frame) resolve_columns(p, axes_of(modelled, p.chain.tip_axes), i, scratch);
  const bool near = move_to_estimate(p.chain, b.joint + at, b.estimate + at, scratch.moved);
  if (!near) compute_motions(p.chain, b.estimate + at, batch_size, scratch.moved);
  const Frame<L> estimate = walk_motions<L>(p.chain, scratch.moved, Ignore{}, Ignore{});
  if (p.as_modelled)
    pose_error(p, estimate, modelled, near, scratch.pose + i);
  else
    pose_error(p, estimate,
               walk<L>(p.built, b.built_joint + at, batch_size, scratch.moved, Ignore{}, Ignore{}), false,
               scratch.pose + i);
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const std::size_t from = e * batch_size + at;
    scratch.residual_counts[depth * e + i] =
        (load<L>(b.measured + from) - load<L>(b.encoder + from)) * p.per_resolution[e];
  }
}

}  // namespace

}  // namespace qerr::lanes
