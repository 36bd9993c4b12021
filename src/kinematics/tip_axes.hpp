#pragma once

#include "kinematics/walk.hpp"

namespace qerr::lanes {
namespace {

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
