#pragma once

#include <vector>

#include "kinematics/folded_chain.hpp"
#include "lanes/batch.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

/// Draws configurations in batches: bit-identical to `draw` on every instruction set, with the constants of
/// the sequences computed once.
class Sampler {
 public:
  /// @pre the configurations outlive it
  explicit Sampler(const Configurations&, InstructionSet = instruction_set());

  /// Configurations first .. first + 63.
  ///
  /// @param to  receives configuration first + c of joint i at to[i * batch_size + c] [rad or m]; aligned to
  /// 64 bytes. Beyond the last configuration the values are arbitrary within the ranges.
  /// @pre first is a multiple of batch_size
  void operator()(std::uint64_t first, double* to);

 private:
  void sobol(std::uint64_t first);
  void grid(std::uint64_t first, double* to) const;

  const Configurations* configurations_;
  InstructionSet set_;
  std::vector<double> lower_, width_, upper_;  // [joint]
  std::vector<std::uint64_t> keys_;            // [joint]: shift of Sobol's sequence, key of random points
  // Sobol's sequence: directions [joint][bit of the Gray code]; offsets of the points within a batch and of
  // the batches within a block [joint][64]; index and first points of the current block, first point of the
  // batch.
  std::vector<std::uint64_t> directions_, patterns_, steps_, block_points_, start_;
  std::uint64_t block_ = ~std::uint64_t{0};
};

/// `joint_jacobian` of batches of configurations, one configuration per vector lane. Differs from it by
/// rounding, about 1e-15 of the arm's length.
class BatchedJacobian {
 public:
  explicit BatchedJacobian(const Chain&, InstructionSet = instruction_set());

  /// @param q   configuration c of independent joint i at q[i * batch_size + c] [rad or m]; aligned to 64
  /// bytes
  /// @param to  receives entry (row, k) of configuration c at to[(6 k + row) * batch_size + c], linear rows
  /// first [m/rad or 1, and 1]; aligned to 64 bytes
  /// @pre |angles| <= 2^20 rad, beyond which sines lose accuracy (lanes.hpp)
  void operator()(const double* q, double* to);

 private:
  FoldedChain chain_;
  InstructionSet set_;
  AlignedNumbers scratch_;
};

}  // namespace qerr
