#pragma once

#include "kinematics/folded_path.hpp"
#include "lanes/lanes.hpp"

namespace qerr::lanes {
namespace {

/// step(0), step(1), step(2): written out, as GCC keeps a frame in registers from joint to joint only where
/// it knows before all loops which of its numbers is meant.
template <class Step>
[[gnu::always_inline]] inline void each_of_three(Step step) {
  step(0);
  step(1);
  step(2);
}

/// A frame of the folded chain in the base frame: its axes and a point on its joint's axis.
template <class L>
struct Frame {
  L x[3], y[3], z[3], o[3];
};

template <class L, class A>
[[gnu::always_inline]] inline void advance(L (&point)[3], const A& length, const L (&along)[3]) {
  each_of_three([&](int i) __attribute__((always_inline)) { point[i] = fma(length, along[i], point[i]); });
}

/// From the frame behind the joint before to that of the joint, still unturned.
template <class L>
[[gnu::always_inline]] inline void approach(const FoldedJoint& joint, Frame<L>& f) {
  if (joint.has_a) advance(f.o, joint.a, f.x);
  if (joint.has_b) advance(f.o, joint.b, f.y);
  if (joint.right) {
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

template <class L, class C>
[[gnu::always_inline]] inline void turn(const C& cosine, const C& sine, Frame<L>& f) {
  each_of_three([&](int i) __attribute__((always_inline)) {
    const L x = f.x[i], y = f.y[i];
    f.x[i] = fma(cosine, x, sine * y);
    f.y[i] = fma(cosine, y, -(sine * x));
  });
}

/// The motion of a joint: its slide, or the sine and cosine of its turn.
///
/// @param q  of independent joint i at q + i * stride [rad or m]
template <class L>
[[gnu::always_inline]] inline void motion(const FoldedJoint& joint, const double* q, std::size_t stride,
                                          SineCosine<L>& to) {
  const L at = load<L>(q + joint.coordinate * stride);
  if (joint.prismatic)
    to.sine = fma(joint.multiplier, at, broadcast<L>(joint.offset));
  else if (joint.turns)
    to = sincos_of_quarters(fma(joint.quarter_multiplier, at, broadcast<L>(joint.quarter_offset)));
}

/// Those of all joints: apart from the walk, as they do not depend on each other and the steps of the walk
/// do.
template <class L>
[[gnu::always_inline]] inline void motions(const FoldedPath& chain, const double* q, std::size_t stride,
                                           SineCosine<L>* to) {
  for (std::size_t k = 0; k < chain.count; ++k) motion(chain.joints[k], q, stride, to[k]);
}

/// Walks a folded chain from base to tip, one configuration per lane, its joints moved as `motions` says.
///
/// @param arrive  called with (k, frame) when the frame stands on the axis of moving joint k: z is the axis
/// times FoldedJoint::sign, o a point on it
/// @param leave   called with (k, frame) when joint k has moved
/// @returns the frame behind the last joint, its point moved to the tip
template <class L, class Arrive, class Leave>
[[gnu::always_inline]] inline Frame<L> walk_moved(const FoldedPath& chain, const SineCosine<L>* moved,
                                                  Arrive arrive, Leave leave) {
  Frame<L> f;
  each_of_three([&](int i) __attribute__((always_inline)) {
    f.x[i] = broadcast<L>(chain.first_axes[i]);
    f.y[i] = broadcast<L>(chain.first_axes[3 + i]);
    f.z[i] = broadcast<L>(chain.first_axes[6 + i]);
    f.o[i] = broadcast<L>(chain.first_point[i]);
  });
  for (std::size_t k = 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    if (k > 0) approach(joint, f);
    arrive(k, f);
    if (joint.prismatic) {
      advance(f.o, moved[k].sine, f.z);
      if (joint.turns) turn(joint.turn_cosine, joint.turn_sine, f);
    } else if (k == 0 && chain.upright && joint.turns) {
      f.x[0] = f.y[1] = chain.axes_length * moved[k].cosine;
      f.x[1] = chain.axes_length * moved[k].sine;
      f.y[0] = -f.x[1];
    } else if (k == 1 && chain.level) {  // y is (0, 0, 1) now, and x has no z
      const auto [sine, cosine] = moved[k];
#pragma GCC unroll 2
      for (int i = 0; i < 2; ++i) {
        f.y[i] = -(sine * f.x[i]);
        f.x[i] = cosine * f.x[i];
      }
      f.x[2] = chain.axes_length * sine;
      f.y[2] = chain.axes_length * cosine;
    } else if (joint.turns) {
      turn(moved[k].cosine, moved[k].sine, f);
    }
    leave(k, f);
  }
  Frame<L> tip = f;  // which the caller may index as it likes
  if (chain.tip_x != 0) advance(tip.o, chain.tip_x, f.x);
  if (chain.tip_y != 0) advance(tip.o, chain.tip_y, f.y);
  return tip;
}

/// The same of joints at q.
///
/// @param q      of independent joint i at q + i * stride [rad or m]
/// @param moved  room for one of each joint
template <class L, class Arrive, class Leave>
[[gnu::always_inline]] inline Frame<L> walk(const FoldedPath& chain, const double* q, std::size_t stride,
                                            SineCosine<L>* moved, Arrive arrive, Leave leave) {
  motions(chain, q, stride, moved);
  return walk_moved<L>(chain, moved, arrive, leave);
}

template <class L>
[[gnu::always_inline]] inline void cross(const L (&a)[3], const L (&b)[3], L (&to)[3]) {
  to[0] = fma(a[1], b[2], -(a[2] * b[1]));
  to[1] = fma(a[2], b[0], -(a[0] * b[2]));
  to[2] = fma(a[0], b[1], -(a[1] * b[0]));
}

/// For walks that keep nothing of the frames, and have nothing to do meanwhile.
struct PassBy {
  template <class L>
  [[gnu::always_inline]] void operator()(std::size_t, const Frame<L>&) const {}
  [[gnu::always_inline]] void operator()(std::size_t) const {}
};

/// What a kernel keeps of each moving joint while it works: the kernel's caller gives it the room, as chains
/// may have any length.
template <class L>
struct JointRoom {
  L column[6];  ///< of the Jacobian: linear, angular
  L point[3];   ///< on the joint's axis
};

/// Whether the first joint turns about the base's z.
[[gnu::always_inline]] inline bool begins_upright(const FoldedPath& chain) {
  return chain.upright && chain.joints[0].turns && !chain.joints[0].prismatic;
}

/// What `columns` keeps of a first joint that turns: its axis stands still whatever the configuration.
template <class L>
[[gnu::always_inline]] inline void begin_columns(const FoldedPath& chain, const double* scale,
                                                 JointRoom<L>* joints) {
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    joints[0].column[3 + i] = broadcast<L>((scale ? scale[0] : 1) * chain.first_axes[6 + i]);
    joints[0].point[i] = broadcast<L>(chain.first_point[i]);
  }
}

/// Walks the chain, its joints moved as `motions` says, then gives the columns of the Jacobian of the moving
/// joints, times a factor each.
///
/// @param scale  the factors; null: all 1
/// @param leave  as of `walk`
/// @param take   its `column(k, linear, angular)` is called for every moving joint, but `upright(x, y, w)`
/// for a first one about the base's z: linear (x, y, 0), angular (0, 0, w). Angular also stays in
/// joints[k].column
/// @param meanwhile  called with k at every joint of the walk, whose steps wait for each other: for work that
/// waits for nothing
/// @returns as `walk`
/// @pre `begin_columns` has been called, once for all configurations
template <class L, class Leave, class Take, class Meanwhile = PassBy>
[[gnu::always_inline]] inline Frame<L> columns_moved(const FoldedPath& chain, const double* scale,
                                                     const SineCosine<L>* moved, JointRoom<L>* joints,
                                                     Leave leave, Take&& take,
                                                     const Meanwhile& meanwhile = {}) {
  const bool upright = begins_upright(chain);
  const Frame<L> tip = walk_moved<L>(
      chain, moved,
      [&](std::size_t k, const Frame<L>& f) {
        meanwhile(k);
        if (k == 0 && !chain.joints[0].prismatic) return;  // `begin_columns` has put it there
        each_of_three([&](int i) __attribute__((always_inline)) {
          joints[k].column[3 + i] = scale ? scale[k] * f.z[i] : f.z[i];
        });
        if (!chain.joints[k].own_point) return;
        each_of_three([&](int i) __attribute__((always_inline)) { joints[k].point[i] = f.o[i]; });
      },
      leave);
  L arm[3] = {};
  if (upright) {
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) arm[i] = tip.o[i] - chain.first_point[i];
    const double w = scale ? scale[0] * chain.axes_length : chain.axes_length;
    take.upright(-(w * arm[1]), w * arm[0], w);
  }
  for (std::size_t k = upright ? 1 : 0; k < chain.count; ++k) {
    const FoldedJoint& joint = chain.joints[k];
    L(&column)[6] = joints[k].column;
    const L axis[3] = {column[3], column[4], column[5]};
    const L still[3] = {};
    if (joint.prismatic) {
      column[3] = column[4] = column[5] = L{};
      take.column(k, axis, still);
    } else if (!joint.turns) {  // the tip lies on the axis
      take.column(k, still, axis);
    } else {
      if (joint.own_point) {
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) arm[i] = tip.o[i] - joints[k].point[i];
      }
      L linear[3];
      cross(axis, arm, linear);
      take.column(k, linear, axis);
    }
  }
  return tip;
}

/// The same of joints at q, as `walk` takes it.
template <class L, class Leave, class Take>
[[gnu::always_inline]] inline Frame<L> columns(const FoldedPath& chain, const double* scale, const double* q,
                                               std::size_t stride, SineCosine<L>* moved, JointRoom<L>* joints,
                                               Leave leave, Take&& take) {
  motions(chain, q, stride, moved);
  return columns_moved<L>(chain, scale, moved, joints, leave, take);
}

/// Keeps the columns with what is kept of the joints.
template <class L>
struct KeepColumns {
  JointRoom<L>* joints;
  [[gnu::always_inline]] void upright(const L& x, const L& y, double) const {
    joints[0].column[0] = x;
    joints[0].column[1] = y;
    joints[0].column[2] = L{};
  }
  [[gnu::always_inline]] void column(std::size_t k, const L (&linear)[3], const L (&)[3]) const {
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) joints[k].column[i] = linear[i];
  }
};

/// sum_k weight_k |linear column k|.
template <class L>
[[gnu::always_inline]] inline L weighted_arms(const FoldedPath& chain, const double* weight,
                                              const JointRoom<L>* joints) {
  L sum{};
  for (std::size_t k = 0; k < chain.count; ++k) {
    const L(&u)[6] = joints[k].column;
    sum = fma(weight[k], sqrt(fma(u[0], u[0], fma(u[1], u[1], u[2] * u[2]))), sum);
  }
  return sum;
}

/// Numbers of room a kernel needs for its moving joints: their motions and what is kept of them.
template <class L>
constexpr std::size_t room_per_joint = (sizeof(SineCosine<L>) + sizeof(JointRoom<L>)) / sizeof(double);

}  // namespace
}  // namespace qerr::lanes
