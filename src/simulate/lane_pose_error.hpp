#pragma once

#include "kinematics/tip_axes.hpp"
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

}  // namespace
}  // namespace qerr::lanes
