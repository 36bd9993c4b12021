#pragma once

#include "kinematics/folded_chain.hpp"
#include "lanes/batch.hpp"
#include "qerr/core/instruction_set.hpp"

namespace qerr {

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
