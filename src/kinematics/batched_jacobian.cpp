#include "kinematics/batched_jacobian.hpp"

#include <vector>

#include "kinematics/kernels.hpp"

namespace qerr {

BatchedJacobian::BatchedJacobian(const Chain& chain, InstructionSet set)
    : chain_(fold(chain, false)),
      set_(set),
      scratch_(chain.joints.size() * select_kernels<KinematicKernels>(set).scratch_per_joint) {}

void BatchedJacobian::operator()(const double* q, double* to) {
  std::vector<double> signs;
  for (const FoldedJoint& joint : chain_.joints) signs.push_back(joint.sign);
  select_kernels<KinematicKernels>(set_).jacobians(path_of(chain_), signs.data(), q, to, scratch_.data());
}

}  // namespace qerr
