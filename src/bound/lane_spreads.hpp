#pragma once

#include "bound/kernels.hpp"
#include "kinematics/euler_rates.hpp"
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
  SineCosine<L>*motions, *ahead;  // [joint]: of this and of the next vector of configurations
  JointScratch<L>* joints;
  L* frames;   // [joint][x, y, z][3]
  L* spreads;  // [part][9]

  Scratch(const ErrorPlan& plan, double* memory)
      : motions(reinterpret_cast<SineCosine<L>*>(memory)),
        ahead(motions + plan.chain.count),
        joints(reinterpret_cast<JointScratch<L>*>(ahead + plan.chain.count)),
        frames(reinterpret_cast<L*>(joints + plan.chain.count)),
        spreads(frames + 9 * plan.chain.count) {}
};

/// Doubles of scratch memory.
template <class L>
std::size_t scratch(const ErrorPlan& plan) {
  return plan.chain.count * scratch_per_joint<L> +
         (11 * plan.chain.count + most_coordinates * plan.parts) * lane_count<L>;
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

}  // namespace
}  // namespace qerr::lanes
