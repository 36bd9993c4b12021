#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

enum class JointType { revolute, continuous, prismatic, fixed, floating, planar };

/// Range of a joint coordinate [rad or m], lower <= upper.
struct Limits {
  double lower = 0;
  double upper = 0;
};

/// q = multiplier * q_joint + offset (URDF `mimic`).
struct Mimic {
  std::string joint;
  double multiplier = 1;
  double offset = 0;
};

/// Mass and inertia tensor of a link.
struct Inertia {
  double mass = 0;                                         ///< [kg]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();        ///< center of mass [m]
  Eigen::Matrix3d about_center = Eigen::Matrix3d::Zero();  ///< inertia tensor about it [kg m^2]
};

/// A joint of the tree: child frame = parent frame * origin * motion about or along `axis` (unit, in the
/// joint frame).
struct Joint {
  std::string name;
  JointType type = JointType::fixed;
  std::string parent, child;
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  std::optional<Limits> limits;  ///< empty: not in the URDF (always so for a continuous joint)
  std::optional<Mimic> mimic;
  Place place;
  std::optional<double> velocity_limit = {};  ///< of <limit>; empty: not given, or 0 [rad/s or m/s]
  std::optional<double> effort_limit = {};    ///< the same [N m or N]
  /// Ratio that the URDF states for the joint's transmission: motor revolutions per joint revolution, for a
  /// prismatic joint motor radians per metre.
  std::optional<double> stated_ratio = {};
};

/// Two motors that move two joints, as a URDF states it: joint motion = coupling * (motor angle / ratio).
struct StatedCoupling {
  std::string transmission, type;
  std::array<std::string, 2> joints;
  std::array<double, 2> ratios{1, 1};  ///< of the motors
  Eigen::Matrix2d coupling = Eigen::Matrix2d::Identity();
};

/// A flaw of the URDF and the part of the robot that it concerns. A flaw of the document as a whole, such as
/// a second root, names neither joints nor a link.
struct Flaw {
  Fault fault;
  bool spoils = false;  ///< the part cannot be used; false: a warning will do
  std::vector<std::string> joints = {};
  std::string link = {};
  /// Link above which a moving joint is missing, since its parent is not known.
  std::string below_missing_joint = {};
};

/// Kinematic trees: at most one parent per link, no cycles, unit axes, ordered finite limits, existing and
/// acyclic mimic targets. A sound URDF has one root; joints that a flaw excludes from the tree are left out.
struct RobotModel {
  std::string name;
  std::string file;
  std::vector<std::string> links;      ///< in file order
  std::vector<Joint> joints;           ///< in file order
  std::vector<Flaw> flaws;             ///< in the order in which they were found
  std::vector<Inertia> inertias = {};  ///< one per link, in its frame; mass 0 if not in the file
  std::vector<StatedCoupling> couplings = {};
};

/// What the name of a link says about it.
enum class EndKind { tool, other, sensor };

/// An end of the tree: a link without children, which may be the tip of a chain.
struct TreeEnd {
  std::string tip;
  std::string base;                 ///< the root, or the link below the last floating or planar joint
  std::vector<std::size_t> joints;  ///< moving joints between the two, indices of RobotModel::joints
  EndKind kind = EndKind::other;
};

/// The ends below `base` (empty: of the whole robot), the likeliest tips first: sensors and ends that no
/// joint moves stand last; among the others the end with the most moving joints is first, and of ends with
/// equally many the one that is named like a tool (`tool0`, `flange`, `*_tcp`, `*_ee`).
std::vector<TreeEnd> tree_ends(const RobotModel&, const std::string& base = "");

/// The base of a chain to the tip: the link below the last floating or planar joint above it, else the root
/// of its tree; empty if that is the only root.
std::string natural_base(const RobotModel&, const std::string& tip);

std::string_view end_kind_name(EndKind);

}  // namespace qerr
