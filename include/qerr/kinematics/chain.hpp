#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// A moving joint between base and tip: frame = previous frame * origin * motion, the motion being a rotation
/// about or a translation along `axis` by multiplier * q[coordinate] + offset.
struct ChainJoint {
  std::string name;
  bool prismatic = false;
  /// Product of all fixed transforms since the previous moving joint.
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  std::size_t coordinate = 0;  ///< index of the independent joint that moves it
  double multiplier = 1;       ///< mimic multiplier; 1 for the joint's own coordinate
  double offset = 0;           ///< [rad or m]
  /// Sum over its child link and everything fixed to it, in the moved joint frame.
  Inertia load = {};
  /// Rotation of the frame of the parent link, in which the URDF gives the joint's <origin>: in the previous
  /// frame, or in the frame behind its motion if it is passed `upward`.
  Eigen::Matrix3d parent_axes = Eigen::Matrix3d::Identity();
  bool upward = false;  ///< the way from base to tip leads from its child link to its parent
};

/// A joint with a coordinate of its own: it has an encoder, and a column in configurations and logs.
struct IndependentJoint {
  std::string name;
  JointType type = JointType::revolute;
  std::optional<Limits> limits;
  bool on_chain = true;                       ///< false: only its mimics move the tips
  std::optional<double> velocity_limit = {};  ///< of the URDF [rad/s or m/s]
  std::optional<double> effort_limit = {};    ///< of the URDF [N m or N]

  bool prismatic() const { return type == JointType::prismatic; }
  const char* unit() const { return prismatic() ? "m" : "rad"; }  ///< of its coordinate
  const char* effort_unit() const { return prismatic() ? "N" : "N m"; }
};

/// The serial chain between two links of a tree, through their common ancestor.
struct Chain {
  std::string base, tip;
  std::vector<ChainJoint> joints;  ///< moving joints, base to tip
  Eigen::Isometry3d tip_offset = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d tracker = Eigen::Isometry3d::Identity();  ///< the base in the frame of a record's tip
  /// In chain order; a master off the chain has the place of its first mimic.
  std::vector<IndependentJoint> independent;
};

/// The chain from `base` (empty: the root) to `tip` (empty: the only leaf).
///
/// A mimic joint moves with its master's coordinate. A joint from child to parent has its axis reversed.
/// Branches beside the chain, and what is above the common ancestor, contribute to its inertias with their
/// joints at zero: the base is held.
/// @throws Error (input; keys `robot.base`, `robot.tip`) for an unknown link, several leaves, two links that
///   no joints connect, a floating or planar joint between them, or no moving joint; with its place in the
///   URDF for a flaw that spoils a joint or link of the chain
Chain make_chain(const RobotModel&, const std::string& base, const std::string& tip);

/// A tip of several, `left`, or one relative to another, `right-left`.
struct NamedTip {
  std::string name;
  Chain chain;  ///< its independent joints are those of all tips
};

/// The chains from `base` to several tips, and from each tip to each other one that it moves against: in a
/// chain from tip to tip the joints in common are absent, so that their errors cancel exactly.
/// @param tips  names and links
/// @returns the tips in their order, then the pairs; all with the same independent joints, in the order of
/// the first chain, then of the next ones
/// @throws Error (input) as make_chain, with the key `robot.tips.NAME`
std::vector<NamedTip> make_chains(const RobotModel&, const std::string& base,
                                  const std::vector<std::pair<std::string, std::string>>& tips);

/// The flaws of the URDF that the chains tolerate, one text for all of one kind; few of those in parts that
/// no chain uses.
std::vector<std::string> warnings_about(const RobotModel&, const std::vector<const Chain*>&);
std::vector<std::string> warnings_about(const RobotModel&, const Chain&);

/// Index of the independent joint of this name.
/// @throws std::out_of_range for an unknown name; names in specs are checked when they are read
std::size_t independent_index(const Chain&, std::string_view name);

/// Index of the moving joint of this name in Chain::joints; empty if the chain does not contain it (such as a
/// master of which only mimics move the tip).
std::optional<std::size_t> find_joint(const Chain&, std::string_view name);

/// Where a displaced <origin> of a joint enters the chain.
struct OriginPlace {
  std::size_t link;  ///< in the frame before this joint of the chain; Chain::joints.size(): before the tip
  Eigen::Matrix3d
      axes;  ///< displacement in that frame of all that follows, per displacement in the parent link
};

/// The place of a joint of the chain, by its index. A joint that is passed upward has its parent behind it:
/// the parent moves against the displacement.
OriginPlace origin_place(const Chain&, std::size_t joint);

/// Pose of the tip in the base frame at the independent coordinates q [rad or m].
Eigen::Isometry3d forward_kinematics(const Chain&, const Eigen::VectorXd& q);

/// Pose of the tip in the tracker's frame.
Eigen::Isometry3d tracked_tip(const Chain&, const Eigen::VectorXd& q);

using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Geometric Jacobian of the chain's moving joints (a mimic has a column of its own) at independent
/// coordinates q.
///
/// Column k: [z_k x (p - o_k); z_k] for a revolute joint, [z_k; 0] for a prismatic one, all in the base
/// frame; linear rows first.
/// @param pose  receives the pose of the tip; may be null
/// @returns 6 x joints; linear rows [m/rad or 1], angular rows [1 or 0]
Jacobian joint_jacobian(const Chain&, const Eigen::VectorXd& q, Eigen::Isometry3d* pose = nullptr);

/// Columns of the independent coordinates: the sum of multiplier times column over the joints that each one
/// moves.
/// @param columns  m x joints
/// @returns m x independent
Eigen::MatrixXd to_independent(const Chain&, const Eigen::MatrixXd& columns);

/// Geometric Jacobian x' = J q' of the independent coordinates, linear rows first (paper, Eq. 15).
/// @returns 6 x independent
Jacobian jacobian(const Chain&, const Eigen::VectorXd& q);

}  // namespace qerr
