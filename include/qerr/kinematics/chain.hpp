#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// A moving joint on the way from base to tip: `origin` (from the frame before), then the motion by
/// multiplier * q[coordinate] + offset about or along `axis`.
struct ChainJoint {
  std::string name;
  bool prismatic = false;
  Eigen::Isometry3d origin =
      Eigen::Isometry3d::Identity();  ///< all fixed transforms before the joint, merged
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  std::size_t coordinate = 0;  ///< index of the independent joint that moves it
  double multiplier = 1;       ///< mimic multiplier; 1 for the joint's own coordinate
  double offset = 0;           ///< [rad or m]
  /// Of everything that moves with it as far as the next moving joint, in its moved frame.
  Inertia load = {};
  /// Axes of the parent link's frame, in which the URDF states the joint's origin, in the frame before.
  Eigen::Matrix3d parent_axes = Eigen::Matrix3d::Identity();
};

/// A joint whose coordinate is free: what has an encoder, what configurations and logs speak of.
struct IndependentJoint {
  std::string name;
  JointType type = JointType::revolute;
  std::optional<Limits> limits;
  bool on_chain = true;                       ///< false: only its mimics are
  std::optional<double> velocity_limit = {};  ///< of the URDF [rad/s or m/s]
  std::optional<double> effort_limit = {};    ///< of the URDF [N m or N]

  bool prismatic() const { return type == JointType::prismatic; }
};

/// The serial chain between two links of a tree.
struct Chain {
  std::string base, tip;
  std::vector<ChainJoint> joints;  ///< moving joints, base to tip
  Eigen::Isometry3d tip_offset = Eigen::Isometry3d::Identity();
  std::vector<IndependentJoint>
      independent;  ///< in chain order; a master off the chain stands where its first mimic does
};

/// The chain from `base` (empty: the root) to `tip` (empty: the only leaf).
///
/// A mimic joint moves with its master's coordinate. Links beside the chain load it as they hang at their
/// zero.
/// @throws Error (input; keys `robot.base`, `robot.tip`) for unknown links, several leaves, a tip that is not
/// beyond the base; for a floating
///   or planar joint on the way, by its name; when nothing moves
Chain make_chain(const RobotModel&, const std::string& base, const std::string& tip);

/// Index of the independent joint of this name.
/// @throws std::out_of_range where there is none; names in specs are checked when they are read
std::size_t independent_index(const Chain&, std::string_view name);

/// Index of the moving joint of this name on the way from base to tip; empty where there is none, as of a
/// master beside the chain, whose mimics alone carry the tip.
std::optional<std::size_t> find_joint(const Chain&, std::string_view name);

/// Pose of the tip in the base frame at the independent coordinates q [rad or m].
Eigen::Isometry3d forward_kinematics(const Chain&, const Eigen::VectorXd& q);

}  // namespace qerr
