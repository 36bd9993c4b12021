#pragma once

#include <cstddef>
#include <cstdint>

#include "kinematics/folded_path.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr {

/// Ranges of the joints [rad or m].
struct SampledRanges {
  std::size_t joints;
  const double *lower, *width, *upper;
};

/// Kernels compiled once per instruction set (lanes/select_kernels.hpp). Batches: batch.hpp.
struct KinematicKernels {
  std::size_t lanes;
  std::size_t scratch_per_joint;  ///< doubles of `scratch` that `jacobians` needs
  /// @param signs  [joint]: FoldedJoint::sign
  void (*jacobians)(const FoldedPath&, const double* signs, const double* q, double* to, double* scratch);
  /// Sobol points, start ^ pattern as fractions of the ranges in units of 2^-53.
  /// @param start     [joint]: first point of the batch
  /// @param patterns  [joint][64]
  void (*sobol)(const SampledRanges&, const std::uint64_t* start, const std::uint64_t* patterns, double* to);
  /// Independent uniform points.
  /// @param keys  [joint]: random_key(seed, joint)
  void (*random)(const SampledRanges&, const std::uint64_t* keys, std::uint64_t first, double* to);
};

}  // namespace qerr
