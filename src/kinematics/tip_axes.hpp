#pragma once

#include "kinematics/kernels.hpp"
#include "kinematics/walk.hpp"
#include "lanes/lanes.hpp"

namespace qerr::lanes {

namespace {

/// Rates of roll, pitch and yaw per unit of angular velocity (coordinates.hpp); all are finite
/// at the gimbal lock, where there are none.
template <class L>
struct EulerRates {
  L rates[3][3];
  L cosine;           ///< of pitch
  Bits<L> unbounded;  ///< cosine < gimbal_lock

  /// Rate of roll (0), pitch (1) or yaw (2) at an angular velocity.
  [[gnu::always_inline]] L along(int angle, const L* velocity) const {
    const L(&r)[3] = rates[angle];
    return fma(r[2], velocity[2], fma(r[1], velocity[1], r[0] * velocity[0]));
  }
};

/// @param x  axis of the tip in the base frame
template <class L>
[[gnu::always_inline]] inline EulerRates<L> euler_rates(const L (&x)[3]) {
  EulerRates<L> r;
  r.cosine = sqrt(fma(x[0], x[0], x[1] * x[1]));
  r.unbounded = r.cosine < gimbal_lock;
  const L inverse = r.unbounded ? L{} : 1.0 / r.cosine;
  const L cos_yaw = x[0] * inverse, sin_yaw = x[1] * inverse, tan_pitch = -x[2] * inverse;
  r.rates[0][0] = cos_yaw * inverse;
  r.rates[0][1] = sin_yaw * inverse;
  r.rates[0][2] = L{};
  r.rates[1][0] = -sin_yaw;
  r.rates[1][1] = cos_yaw;
  r.rates[1][2] = L{};
  r.rates[2][0] = tan_pitch * cos_yaw;
  r.rates[2][1] = tan_pitch * sin_yaw;
  r.rates[2][2] = r.unbounded ? L{} : broadcast<L>(1);
  return r;
}

/// Axes of a tip: columns of its rotation.
template <class L>
struct Axes {
  L x[3], y[3], z[3];

  /// Replaces a vector in the axes of the base by its components along these.
  [[gnu::always_inline]] void resolve(L* v) const {
    const L base[3] = {v[0], v[1], v[2]};
    const auto along = [&](const L(&axis)[3]) __attribute__((always_inline)) {
      return fma(axis[2], base[2], fma(axis[1], base[1], axis[0] * base[0]));
    };
    v[0] = along(x);
    v[1] = along(y);
    v[2] = along(z);
  }
};

template <class L>
[[gnu::always_inline]] inline Axes<L> axes_of(const Frame<L>& f, const double* rotation) {
  Axes<L> a;
  each_of_three([&](int i) __attribute__((always_inline)) {
    const auto along = [&](int c) __attribute__((always_inline)) {
      return fma(rotation[3 * c + 2], f.z[i], fma(rotation[3 * c + 1], f.y[i], rotation[3 * c] * f.x[i]));
    };
    a.x[i] = along(0);
    a.y[i] = along(1);
    a.z[i] = along(2);
  });
  return a;
}

template <class L>
[[gnu::always_inline]] inline Axes<L> axes_of(const Frame<L>& f) {
  Axes<L> a;
  each_of_three([&](int i) __attribute__((always_inline)) {
    a.x[i] = f.x[i];
    a.y[i] = f.y[i];
    a.z[i] = f.z[i];
  });
  return a;
}

}  // namespace

}  // namespace qerr::lanes
