#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/robot_model.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// Pose of the tip in the frame of the base at given joint values.
struct PoseAtJoints {
  std::string base, tip;
  std::vector<std::pair<IndependentJoint, double>> joints;  ///< in chain order, with their values [rad or m]
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  std::vector<std::string> warnings;  ///< of values outside a joint's limits
};

/// What a URDF, or the robot of a spec, holds, as `qerr robot` shows it.
struct RobotReport {
  RobotModel robot;
  std::string sha256;              ///< of the URDF's bytes
  std::vector<std::string> roots;  ///< links without a parent; one in a sound URDF
  std::vector<TreeEnd> ends;       ///< the likeliest tips first
  /// Base and tip of the first spec; empty if no chain can be used.
  std::string base, tip;
  std::string obstacle;   ///< why none can be used; empty otherwise
  std::string spec_file;  ///< to which the first spec was written; empty: it was not
  bool of_spec = false;   ///< the robot is that of `spec_file`
  std::optional<PoseAtJoints> pose = {};
};

/// @param base, tip  of the first spec; empty: chosen by `first_chain`
/// @throws Error (input) if a base or tip that is given cannot be used
RobotReport robot_report(RobotModel, const std::string& text, const std::string& base = "",
                         const std::string& tip = "");

/// Reads `JOINT=VALUE` for joints of a chain, such as `q1=30deg`; the others are at 0.
/// @throws Error (input) for a joint that the chain does not have, or a value of the wrong dimension
PoseAtJoints pose_at(const RobotModel&, const Chain&, const std::vector<std::string>& values);

}  // namespace qerr
