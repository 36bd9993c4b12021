// KDL: ChainJntToJacSolver gives the Jacobian of the chain's end in the base's axes; no pose is needed.

#include <kdl/config.h>

#include <kdl/chain.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "peers.hpp"
#include "scalar_job.hpp"

namespace qerr::bench {

namespace {

KDL::Vector vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame frame(const Eigen::Isometry3d& t) {
  const Eigen::Matrix3d r = t.linear();
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
          vector(t.translation())};
}

/// A joint about a coordinate axis if possible, for which KDL needs no Rodrigues formula.
KDL::Joint joint(const ChainJoint& j) {
  using K = KDL::Joint;
  constexpr std::array turns{K::RotX, K::RotY, K::RotZ}, slides{K::TransX, K::TransY, K::TransZ};
  for (int i = 0; i < 3; ++i)
    if (j.axis == Eigen::Vector3d::Unit(i)) {
      const auto at = static_cast<std::size_t>(i);
      return K(j.name, j.prismatic ? slides[at] : turns[at]);
    }
  return K(j.name, KDL::Vector::Zero(), vector(j.axis), j.prismatic ? K::TransAxis : K::RotAxis);
}

/// Tuned by hand: fixed transforms after the joints, joints about coordinate axes.
KDL::Chain tuned(const Chain& chain) {
  KDL::Chain result;
  result.addSegment(
      KDL::Segment("base", KDL::Joint("base", KDL::Joint::Fixed), frame(chain.joints[0].origin)));
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const bool last = k + 1 == chain.joints.size();
    const Eigen::Isometry3d& after = last ? chain.tip_offset : chain.joints[k + 1].origin;
    result.addSegment(KDL::Segment(chain.joints[k].name, joint(chain.joints[k]), frame(after)));
  }
  return result;
}

/// As kdl_parser builds it from a URDF, the usual case: each joint has an arbitrary axis in the previous
/// frame.
KDL::Chain parsed(const Chain& chain) {
  KDL::Chain result;
  for (const ChainJoint& j : chain.joints) {
    const KDL::Frame origin = frame(j.origin);
    const auto kind = j.prismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
    result.addSegment(
        KDL::Segment(j.name, KDL::Joint(j.name, origin.p, origin.M * vector(j.axis), kind), origin));
  }
  result.addSegment(KDL::Segment("tip", KDL::Joint("tip", KDL::Joint::Fixed), frame(chain.tip_offset)));
  return result;
}

template <KDL::Chain (*chain_of)(const Chain&)>
class KdlArm {
 public:
  static constexpr int linear = 0;

  explicit KdlArm(const Problem& p)
      : chain_(chain_of(p.model.chain)),
        solver_(chain_),
        q_(chain_.getNrOfJoints()),
        jacobian_(chain_.getNrOfJoints()) {}

  const Matrix6X& jacobian(const double* motions) {
    std::copy_n(motions, q_.data.size(), q_.data.data());
    solver_.JntToJac(q_, jacobian_);
    return jacobian_.data;
  }

 private:
  KDL::Chain chain_;  // the solver keeps a reference to it
  KDL::ChainJntToJacSolver solver_;
  KDL::JntArray q_;
  KDL::Jacobian jacobian_;
};

}  // namespace

Contestant kdl() {
  return scalar_contestant<KdlArm<parsed>>(
      "KDL", std::string(KDL_VERSION_STRING) + ", chain as of kdl_parser, caller " QERR_PEER_FLAGS);
}

Contestant kdl_tuned() {
  return scalar_contestant<KdlArm<tuned>>("KDL tuned",
                                          std::string(KDL_VERSION_STRING) + ", caller " QERR_PEER_FLAGS);
}

}  // namespace qerr::bench
