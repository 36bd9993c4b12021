#include <vector>

#include "kinematics/kernels.hpp"
#include "kinematics/sampler.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

Jacobian joint_jacobian(const Chain& chain, const Eigen::VectorXd& q, Eigen::Isometry3d* tip_pose) {
  const auto count = std::ssize(chain.joints);
  Jacobian result(6, count);
  Eigen::Matrix3Xd origins(3, count);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (Eigen::Index k = 0; k < count; ++k) {
    const ChainJoint& joint = chain.joints[k];
    const double motion = joint.multiplier * q[joint.coordinate] + joint.offset;
    pose = pose * joint.origin;
    origins.col(k) = pose.translation();
    result.col(k).tail<3>() = pose.linear() * joint.axis;
    if (joint.prismatic)
      pose.translate(motion * joint.axis);
    else
      pose.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  pose = pose * chain.tip_offset;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector3d axis = result.col(k).tail<3>();
    if (chain.joints[k].prismatic) {
      result.col(k) << axis, Eigen::Vector3d::Zero();
    } else {
      const Eigen::Vector3d arm = pose.translation() - origins.col(k);
      result.col(k).head<3>() = axis.cross(arm);
    }
  }
  if (tip_pose) *tip_pose = pose;
  return result;
}

Eigen::MatrixXd to_independent(const Chain& chain, const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd folded = Eigen::MatrixXd::Zero(columns.rows(), std::ssize(chain.independent));
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const ChainJoint& joint = chain.joints[k];
    folded.col(joint.coordinate) += joint.multiplier * columns.col(k);
  }
  return folded;
}

Jacobian jacobian(const Chain& chain, const Eigen::VectorXd& q) {
  return to_independent(chain, joint_jacobian(chain, q));
}

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
