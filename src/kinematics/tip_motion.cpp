#include "kinematics/tip_motion.hpp"

namespace qerr {

TipMotion tip_motion(const Chain& chain, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                     const Eigen::VectorXd& acceleration) {
  using Eigen::Vector3d;
  TipMotion tip;
  Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero(), origin = Vector3d::Zero();
  // Moves the velocities from `origin` to a point that is fixed in the frame.
  const auto move_to = [&](const Vector3d& point) {
    const Vector3d step = point - origin;
    tip.velocity += w.cross(step);
    tip.acceleration += alpha.cross(step) + w.cross(w.cross(step));
    origin = point;
  };
  for (const ChainJoint& joint : chain.joints) {
    const auto i = static_cast<Eigen::Index>(joint.coordinate);
    const double s = joint.multiplier * q[i] + joint.offset;
    const double v = joint.multiplier * velocity[i], dv = joint.multiplier * acceleration[i];
    tip.pose = tip.pose * joint.origin;
    const Vector3d axis = tip.pose.linear() * joint.axis;
    if (joint.prismatic) {
      tip.pose.translate(s * joint.axis);
      move_to(tip.pose.translation());
      tip.velocity += v * axis;
      tip.acceleration += 2 * v * w.cross(axis) + dv * axis;
    } else {
      move_to(tip.pose.translation());
      tip.pose.rotate(Eigen::AngleAxisd(s, joint.axis));
      alpha += dv * axis + v * w.cross(axis);
      w += v * axis;
    }
  }
  tip.pose = tip.pose * chain.tip_offset;
  move_to(tip.pose.translation());
  return tip;
}

}  // namespace qerr
