// Pinocchio: computeJointJacobians and getFrameJacobian, its fastest Jacobian of a frame, with
// the world's axes at the frame's origin.

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include "peers.hpp"
#include "scalar_job.hpp"

namespace qerr::bench {

namespace {

namespace pin = pinocchio;

pin::SE3 placement(const Eigen::Isometry3d& t) { return pin::SE3(t.linear(), t.translation()); }

/// A joint about a coordinate axis if possible, as in Pinocchio's URDF reader.
pin::JointModel joint(const ChainJoint& j) {
  const auto along = [&](int i) { return j.axis == Eigen::Vector3d::Unit(i); };
  if (j.prismatic) {
    if (along(0)) return pin::JointModel(pin::JointModelPX());
    if (along(1)) return pin::JointModel(pin::JointModelPY());
    if (along(2)) return pin::JointModel(pin::JointModelPZ());
    return pin::JointModel(pin::JointModelPrismaticUnaligned(j.axis));
  }
  if (along(0)) return pin::JointModel(pin::JointModelRX());
  if (along(1)) return pin::JointModel(pin::JointModelRY());
  if (along(2)) return pin::JointModel(pin::JointModelRZ());
  return pin::JointModel(pin::JointModelRevoluteUnaligned(j.axis));
}

pin::Model model_of(const Chain& chain) {
  pin::Model model;
  pin::JointIndex last = 0;
  for (const ChainJoint& j : chain.joints) last = model.addJoint(last, joint(j), placement(j.origin), j.name);
  model.addFrame(pin::Frame("qerr tip", last, 0, placement(chain.tip_offset), pin::OP_FRAME));
  return model;
}

class PinocchioArm {
 public:
  static constexpr int linear = 0;

  explicit PinocchioArm(const Problem& p)
      : model_(model_of(p.model.chain)),
        data_(model_),
        tip_(model_.getFrameId("qerr tip")),
        q_(model_.nq),
        jacobian_(Matrix6X::Zero(6, model_.nv)) {}

  const Matrix6X& jacobian(const double* motions) {
    std::copy_n(motions, q_.size(), q_.data());
    pin::computeJointJacobians(model_, data_, q_);
    pin::getFrameJacobian(model_, data_, tip_, pin::LOCAL_WORLD_ALIGNED, jacobian_);
    return jacobian_;
  }

 private:
  pin::Model model_;
  pin::Data data_;
  pin::FrameIndex tip_;
  Eigen::VectorXd q_;
  Matrix6X jacobian_;
};

}  // namespace

Contestant pinocchio_peer() {
  return scalar_contestant<PinocchioArm>("Pinocchio", QERR_PEER_VERSION ", caller " QERR_PEER_FLAGS);
}

}  // namespace qerr::bench
