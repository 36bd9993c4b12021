#include "kinematics/inverse_dynamics.hpp"

#include <algorithm>
#include <vector>

namespace qerr {

namespace {

/// A joint's frame and its load, in the base frame.
struct Link {
  Eigen::Vector3d origin, axis, center;
  Eigen::Vector3d force, moment;  ///< inertial and gravity wrench of the load, moment about its center
};

/// Moves a pose from one joint's frame to the next one's, at the joint's coordinate s. @returns its axis
Eigen::Vector3d move_behind(Eigen::Isometry3d& pose, const ChainJoint& joint, double s) {
  pose = pose * joint.origin;
  const Eigen::Vector3d axis = pose.linear() * joint.axis;
  if (joint.prismatic)
    pose.translate(s * joint.axis);
  else
    pose.rotate(Eigen::AngleAxisd(s, joint.axis));
  return axis;
}

}  // namespace

Eigen::VectorXd inverse_dynamics(const Chain& chain, const Eigen::VectorXd& q,
                                 const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration) {
  using Eigen::Vector3d;
  std::vector<Link> links;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero(), origin = Vector3d::Zero();
  Vector3d a(0, 0, standard_gravity);  // of the origin; gravity enters as an upward acceleration of the base
  for (const ChainJoint& joint : chain.joints) {
    const auto i = static_cast<Eigen::Index>(joint.coordinate);
    const double s = joint.multiplier * q[i] + joint.offset;
    const double v = joint.multiplier * velocity[i], dv = joint.multiplier * acceleration[i];
    const Vector3d axis = move_behind(pose, joint, s);
    const Vector3d step = pose.translation() - origin;
    a += alpha.cross(step) + w.cross(w.cross(step));
    origin = pose.translation();
    if (joint.prismatic) {
      a += 2 * v * w.cross(axis) + dv * axis;
    } else {
      alpha += dv * axis + v * w.cross(axis);
      w += v * axis;
    }
    const Vector3d arm = pose.linear() * joint.load.center;
    const Eigen::Matrix3d inertia = pose.linear() * joint.load.about_center * pose.linear().transpose();
    links.push_back({origin, axis, origin + arm,
                     joint.load.mass * (a + alpha.cross(arm) + w.cross(w.cross(arm))),
                     inertia * alpha + w.cross(inertia * w)});
  }
  Eigen::VectorXd effort = Eigen::VectorXd::Zero(std::ssize(chain.independent));
  Vector3d force = Vector3d::Zero(),
           moment = Vector3d::Zero();  // of all links from k on, moment about the origin of the base
  for (std::size_t k = links.size(); k-- > 0;) {
    const Link& link = links[k];
    force += link.force;
    moment += link.moment + link.center.cross(link.force);
    const ChainJoint& joint = chain.joints[k];
    const double own = link.axis.dot(joint.prismatic ? force : Vector3d(moment - link.origin.cross(force)));
    effort[joint.coordinate] += joint.multiplier * own;
  }
  return effort;
}

double inertia_at(const Chain& chain, std::size_t independent, const Eigen::VectorXd& q) {
  using Eigen::Vector3d;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Vector3d w = Vector3d::Zero(), v = Vector3d::Zero(), origin = Vector3d::Zero();
  double twice_energy = 0;
  for (const ChainJoint& joint : chain.joints) {
    const double s = joint.multiplier * q[joint.coordinate] + joint.offset;
    const Vector3d axis = move_behind(pose, joint, s);
    v += w.cross(pose.translation() - origin);
    origin = pose.translation();
    if (joint.coordinate == independent) (joint.prismatic ? v : w) += joint.multiplier * axis;
    const Vector3d in_link = pose.linear().transpose() * w;
    twice_energy += joint.load.mass * (v + w.cross(pose.linear() * joint.load.center)).squaredNorm() +
                    in_link.dot(joint.load.about_center * in_link);
  }
  return twice_energy;
}

bool has_masses(const Chain& chain) {
  return std::ranges::any_of(chain.joints, [](const ChainJoint& joint) { return joint.load.mass > 0; });
}

}  // namespace qerr
