// RBDL: CalcPointJacobian6D, which updates the kinematics and gives the angular rows first, base axes.

#include <rbdl/rbdl.h>

#include "peers.hpp"
#include "scalar_job.hpp"

namespace qerr::bench {

namespace {

namespace rbd = RigidBodyDynamics;

/// RBDL's transforms apply to coordinates: the transpose of the rotation, with the origin in the parent's
/// axes.
rbd::Math::SpatialTransform transform(const Eigen::Isometry3d& t) {
  return rbd::Math::SpatialTransform(rbd::Math::Matrix3d(t.linear().transpose()),
                                     rbd::Math::Vector3d(t.translation()));
}

/// A joint about a coordinate axis if possible.
rbd::Joint joint(const ChainJoint& j) {
  const Eigen::Vector3d& a = j.axis;
  if (j.prismatic) return rbd::Joint(rbd::Math::SpatialVector(0., 0., 0., a.x(), a.y(), a.z()));
  constexpr std::array turns{rbd::JointTypeRevoluteX, rbd::JointTypeRevoluteY, rbd::JointTypeRevoluteZ};
  for (int i = 0; i < 3; ++i)
    if (a == Eigen::Vector3d::Unit(i)) return rbd::Joint(turns[static_cast<std::size_t>(i)]);
  return rbd::Joint(rbd::JointTypeRevolute, rbd::Math::Vector3d(a.x(), a.y(), a.z()));
}

class RbdlArm {
 public:
  static constexpr int linear = 3;

  explicit RbdlArm(const Problem& p) {
    for (const ChainJoint& j : p.model.chain.joints)
      tip_body_ = model_.AddBody(tip_body_, transform(j.origin), joint(j), rbd::Body(), j.name);
    tip_ = p.model.chain.tip_offset.translation();
    const auto n = static_cast<Eigen::Index>(p.model.chain.joints.size());
    q_ = rbd::Math::VectorNd::Zero(n);
    jacobian_ = rbd::Math::MatrixNd::Zero(6, n);  // the function writes non-zero entries only
  }

  const rbd::Math::MatrixNd& jacobian(const double* motions) {
    std::copy_n(motions, q_.size(), q_.data());
    rbd::CalcPointJacobian6D(model_, q_, tip_body_, tip_, jacobian_);
    return jacobian_;
  }

 private:
  rbd::Model model_;
  unsigned int tip_body_ = 0;
  rbd::Math::Vector3d tip_;
  rbd::Math::VectorNd q_;
  rbd::Math::MatrixNd jacobian_;
};

}  // namespace

Contestant rbdl() {
  return scalar_contestant<RbdlArm>("RBDL", QERR_PEER_VERSION ", caller " QERR_PEER_FLAGS);
}

}  // namespace qerr::bench
