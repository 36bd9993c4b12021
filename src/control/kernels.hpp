#pragma once

#include <cstddef>

#include "filter/run/section_recursion.hpp"
#include "lanes/select_kernels.hpp"

// Interface of the kernel of closed loops, which is compiled once per instruction set
// (lanes/select_kernels.hpp).

namespace qerr {

/// Loops that are run side by side.
inline constexpr std::size_t loops_of_run = 16;

/// What the loops of a run have in common, and their plants. A row has one number for each loop.
struct LoopPlan {
  double kp, kd;
  const NormalizedSection<double>* sections;  ///< of the velocity filter
  std::size_t section_count;
  const double* taps;  ///< of a velocity filter without sections
  std::size_t tap_count;
  std::size_t whole_delay;  ///< [samples]
  bool late;                ///< the delay has a part of a sample
  /// Rows of the motion over the late part of a sample and the rest of it: q_of_v, q_of_u, v_of_v, v_of_u.
  const double *before, *after;
};

/// Rows of the states and sums, in this order.
struct LoopRows {
  enum : std::size_t {
    q,
    v,
    error,
    sums,
    torques = sums + 6
  };  ///< sums of motion and of torque: |h|, h^2, h
  static std::size_t count(const LoopPlan& p) {
    return torques + p.whole_delay + 2 + 2 * p.section_count + p.tap_count;
  }
};

struct LoopKernels {
  /// Runs the loops; the error is added to the first reading.
  /// @param rows  updated
  /// @param done  samples that have been run before
  void (*run)(const LoopPlan&, double* rows, std::size_t done, std::size_t samples);
};

}  // namespace qerr
