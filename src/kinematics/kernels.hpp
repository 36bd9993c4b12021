#pragma once

#include <cstddef>
#include <cstdint>

#include "kinematics/folded_path.hpp"
#include "lanes/dispatch.hpp"

namespace qerr {

/// Ranges of the joints, one after the other.
struct SampledRanges {
  std::size_t joints;
  const double *lower, *width, *upper;
};

/// What is compiled once per instruction set (instruction_sets/).
struct KinematicKernels {
  std::size_t lanes;
  std::size_t room_per_joint;  ///< numbers that `jacobians` works in
  void (*jacobians)(const FoldedPath&, const double* signs, const double* q, double* to, double* room);
  /// Points as fractions of the ranges, in units of 2^-53.
  /// @param start     of every joint, of the first point of the batch
  /// @param patterns  [joint][64]: what the following points differ by
  void (*sobol)(const SampledRanges&, const std::uint64_t* start, const std::uint64_t* patterns, double* to);
  /// @param keys  of every joint, mixed from seed and joint
  void (*random)(const SampledRanges&, const std::uint64_t* keys, std::uint64_t first, double* to);
};

}  // namespace qerr
