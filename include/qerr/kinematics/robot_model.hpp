#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
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

/// Mass of a link and how it is spread.
struct Inertia {
  double mass = 0;                                         ///< [kg]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();        ///< of mass, in the frame at hand [m]
  Eigen::Matrix3d about_center = Eigen::Matrix3d::Zero();  ///< [kg m^2], axes of the frame at hand
};

/// A joint of the tree; the child frame is `origin` times the motion about or along `axis` (unit, in the
/// joint frame).
struct Joint {
  std::string name;
  JointType type = JointType::fixed;
  std::string parent, child;
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  std::optional<Limits> limits;  ///< empty: the URDF gives none (always so for a continuous joint)
  std::optional<Mimic> mimic;
  Place place;
  std::optional<double> velocity_limit = {};  ///< of <limit>; empty where it gives none, or 0 [rad/s or m/s]
  std::optional<double> effort_limit = {};    ///< the same [N m or N]
};

/// A kinematic tree, checked: one root, every link reachable, one parent a link, unit axes, ordered finite
/// limits, mimic targets present and acyclic.
struct RobotModel {
  std::string name;
  std::string file;
  std::vector<std::string> links;  ///< in file order
  std::vector<Joint> joints;       ///< in file order
  std::vector<std::string> warnings;
  std::vector<Inertia> inertias = {};  ///< one per link, in its frame; without mass where the file gives none
};

}  // namespace qerr
