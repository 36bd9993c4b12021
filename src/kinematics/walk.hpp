#pragma once

#include "kinematics/kernels.hpp"
#include "lanes/lanes.hpp"

namespace qerr::lanes {
namespace {

/// step(0), step(1), step(2), written out: GCC keeps a frame in registers from joint to joint only if all its
/// indices are constant before loop optimization.
template <class Step>
[[gnu::always_inline]] inline void each_of_three(Step step) {
  step(0);
  step(1);
  step(2);
}

/// A frame of the folded chain in the base frame: axes and a point on the joint's axis.
template <class L>
struct Frame {
  L x[3], y[3], z[3], o[3];
};

/// point += length along.
template <class L, class A>
[[gnu::always_inline]] inline void advance(L (&point)[3], const A& length, const L (&along)[3]) {
  each_of_three([&](int i) __attribute__((always_inline)) { point[i] = fma(length, along[i], point[i]); });
}

/// From the frame behind the previous joint to the frame of the joint before its motion.
template <class L>
[[gnu::always_inline]] inline void apply_link(const FoldedJoint& joint, Frame<L>& f) {
  if (joint.has_a) advance(f.o, joint.a, f.x);
  if (joint.has_b) advance(f.o, joint.b, f.y);
  if (joint.right_angle) {
    each_of_three([&](int i) __attribute__((always_inline)) {
      const L z = f.z[i];
      f.z[i] = f.y[i];
      f.y[i] = z;
    });
  }
  if (joint.tilts) {
    each_of_three([&](int i) __attribute__((always_inline)) {
      const L y = fma(joint.half_tangent, f.z[i], f.y[i]);
      f.z[i] = f.z[i] - joint.sine * y;
      f.y[i] = fma(joint.half_tangent, f.z[i], y);
    });
  }
  if (joint.has_d) advance(f.o, joint.d, f.z);
}

/// Rotates the frame about its z.
template <class L, class C>
[[gnu::always_inline]] inline void rotate(const C& cosine, const C& sine, Frame<L>& f) {
  each_of_three([&](int i) __attribute__((always_inline)) {
    const L x = f.x[i], y = f.y[i];
    f.x[i] = fma(cosine, x, sine * y);
    f.y[i] = fma(cosine, y, -(sine * x));
  });
}

/// Motions of all joints: sine and cosine of a rotation, or the translation in place of the sine. Computed
/// before the recursion along the chain because they are independent of each other.
///
/// @param q  independent joint i at q + i * stride [rad or m]
template <class L>
[[gnu::always_inline]] inline void compute_motions(const FoldedPath& chain, const double* q,
                                                   std::size_t stride, SineCosine<L>* to) {
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    const L coordinate = load<L>(q + joint.coordinate * stride);
    if (joint.prismatic)
      to[k].sine = fma(joint.multiplier, coordinate, broadcast<L>(joint.offset));
    else if (joint.rotates)
      to[k] =
          sincos_of_quarters(fma(joint.quarter_multiplier, coordinate, broadcast<L>(joint.quarter_offset)));
  }
}

/// Forward kinematics of a folded chain, one configuration per lane.
///
/// @param motions  [joint]: of `compute_motions`
/// @param before   called with (k, frame) before the motion of joint k: z is its axis times
/// FoldedJoint::sign, o a point on it
/// @param after    called with (k, frame) after the motion of joint k
/// @returns the frame behind the last joint, with o at the tip
template <class L, class Before, class After>
[[gnu::always_inline]] inline Frame<L> walk_motions(const FoldedPath& chain, const SineCosine<L>* motions,
                                                    Before before, After after) {
  Frame<L> f;
  each_of_three([&](int i) __attribute__((always_inline)) {
    f.x[i] = broadcast<L>(chain.first_axes[i]);
    f.y[i] = broadcast<L>(chain.first_axes[3 + i]);
    f.z[i] = broadcast<L>(chain.first_axes[6 + i]);
    f.o[i] = broadcast<L>(chain.first_point[i]);
  });
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    if (k > 0) apply_link(joint, f);
    before(k, f);
    if (joint.prismatic) {
      advance(f.o, motions[k].sine, f.z);
      if (joint.rotates) rotate(joint.rotation_cosine, joint.rotation_sine, f);
    } else if (joint.rotates) {
      rotate(motions[k].cosine, motions[k].sine, f);
    }
    after(k, f);
  }
  Frame<L> tip = f;  // a copy: the caller may index it at run time without forcing f into memory
  if (chain.tip_x != 0) advance(tip.o, chain.tip_x, f.x);
  if (chain.tip_y != 0) advance(tip.o, chain.tip_y, f.y);
  return tip;
}

/// The tip as of `walk`, for joint coordinates.
///
/// @param q        independent joint i at q + i * stride [rad or m]
/// @param motions  [joint]: scratch
template <class L, class Before, class After>
[[gnu::always_inline]] inline Frame<L> walk(const FoldedPath& chain, const double* q, std::size_t stride,
                                            SineCosine<L>* motions, Before before, After after) {
  compute_motions(chain, q, stride, motions);
  return walk_motions<L>(chain, motions, before, after);
}

template <class L>
[[gnu::always_inline]] inline void cross(const L (&a)[3], const L (&b)[3], L (&to)[3]) {
  to[0] = fma(a[1], b[2], -(a[2] * b[1]));
  to[1] = fma(a[2], b[0], -(a[0] * b[2]));
  to[2] = fma(a[0], b[1], -(a[1] * b[0]));
}

/// Callback that does nothing.
struct Ignore {
  template <class L>
  [[gnu::always_inline]] void operator()(std::size_t, const Frame<L>&) const {}
};

/// Intermediate results of one moving joint; the caller of a kernel allocates one per joint of the chain.
template <class L>
struct JointScratch {
  L column[6];  ///< of the Jacobian: linear, angular
  L point[3];   ///< on the joint's axis
};

/// Axis and point of a revolute first joint, which do not depend on the configuration.
template <class L>
[[gnu::always_inline]] inline void prepare_first_joint(const FoldedPath& chain, const double* scale,
                                                       JointScratch<L>* joints) {
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    joints[0].column[3 + i] = broadcast<L>((scale ? scale[0] : 1) * chain.first_axes[6 + i]);
    joints[0].point[i] = broadcast<L>(chain.first_point[i]);
  }
}

/// Forward kinematics, then the columns of the Jacobian of the moving joints, each times a factor.
///
/// @param scale        [joint]: the factors; null: all 1
/// @param after        as of `walk_motions`
/// @param consumer     receives `column(k, linear, angular)` of every moving joint; angular is also stored in
/// joints[k].column
/// @returns as `walk_motions`
/// @pre `prepare_first_joint` has been called, once for all configurations
template <class L, class After, class Consumer>
[[gnu::always_inline]] inline Frame<L> columns_of_motions(const FoldedPath& chain, const double* scale,
                                                          const SineCosine<L>* motions,
                                                          JointScratch<L>* joints, After after,
                                                          Consumer&& consumer) {
  const Frame<L> tip = walk_motions<L>(
      chain, motions,
      [&](std::size_t k, const Frame<L>& f) {
        if (k == 0 && !chain.joints[0].prismatic) return;  // stored by `prepare_first_joint`
        each_of_three([&](int i) __attribute__((always_inline)) {
          joints[k].column[3 + i] = scale ? scale[k] * f.z[i] : f.z[i];
        });
        if (!chain.joints[k].own_point) return;
        each_of_three([&](int i) __attribute__((always_inline)) { joints[k].point[i] = f.o[i]; });
      },
      after);
  L arm[3] = {};
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    L(&column)[6] = joints[k].column;
    const L axis[3] = {column[3], column[4], column[5]};
    const L zero[3] = {};
    if (joint.prismatic) {
      column[3] = column[4] = column[5] = L{};
      consumer.column(k, axis, zero);
    } else if (!joint.rotates) {  // the tip lies on the axis
      consumer.column(k, zero, axis);
    } else {
      if (joint.own_point) {
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) arm[i] = tip.o[i] - joints[k].point[i];
      }
      L linear[3];
      cross(axis, arm, linear);
      consumer.column(k, linear, axis);
    }
  }
  return tip;
}

/// The tip and its columns for joint coordinates, as `walk`.
template <class L, class After, class Consumer>
[[gnu::always_inline]] inline Frame<L> columns(const FoldedPath& chain, const double* scale, const double* q,
                                               std::size_t stride, SineCosine<L>* motions,
                                               JointScratch<L>* joints, After after, Consumer&& consumer) {
  compute_motions(chain, q, stride, motions);
  return columns_of_motions<L>(chain, scale, motions, joints, after, consumer);
}

/// Stores the columns in the scratch of the joints.
template <class L>
struct StoreColumns {
  JointScratch<L>* joints;
  [[gnu::always_inline]] void column(std::size_t k, const L (&linear)[3], const L (&)[3]) const {
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) joints[k].column[i] = linear[i];
  }
};

/// sum_k weight_k |linear column k|.
template <class L>
[[gnu::always_inline]] inline L weighted_column_norms(const FoldedPath& chain, const double* weight,
                                                      const JointScratch<L>* joints) {
  L sum{};
  for (std::size_t k = 0; k < chain.count; ++k) {
    const L(&u)[6] = joints[k].column;
    sum = fma(weight[k], sqrt(fma(u[0], u[0], fma(u[1], u[1], u[2] * u[2]))), sum);
  }
  return sum;
}

/// Doubles of scratch memory that a kernel needs per moving joint: its motion and JointScratch.
template <class L>
constexpr std::size_t scratch_per_joint = (sizeof(SineCosine<L>) + sizeof(JointScratch<L>)) / sizeof(double);

}  // namespace
}  // namespace qerr::lanes
