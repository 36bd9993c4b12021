#pragma once

#include <vector>

#include "lanes/batch.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

/// Draws configurations in batches, with what does not change from batch to batch worked out beforehand. The
/// same numbers as those of `draw`, to the last bit, on every instruction set.
class Sampler {
 public:
  /// @pre the configurations outlive it
  explicit Sampler(const Configurations&, InstructionSet = instruction_set());

  /// Configurations first .. first + 63.
  ///
  /// @param to  receives configuration first + c of joint i at to[i * batch_size + c] [rad or m]; aligned to
  /// 64 bytes. Behind the last configuration stand further ones of the same ranges.
  /// @pre first is a multiple of batch_size
  void operator()(std::uint64_t first, double* to);

 private:
  void sobol(std::uint64_t first);
  void grid(std::uint64_t first, double* to) const;

  const Configurations* configurations_;
  InstructionSet set_;
  std::vector<double> lower_, width_, upper_;  // [joint]
  std::vector<std::uint64_t> keys_;            // [joint]: shift of Sobol's sequence, key of random points
  // Of Sobol's sequence: [joint][bit of the Gray code]; [joint][64], what points of a batch, and what batches
  // of a block of 64, differ by; the last block and its first points, and a batch's.
  std::vector<std::uint64_t> directions_, patterns_, steps_, block_points_, start_;
  std::uint64_t block_ = ~std::uint64_t{0};
};

}  // namespace qerr
