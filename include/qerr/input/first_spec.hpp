#pragma once

#include <string>
#include <vector>

#include "qerr/effect/effect.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// The text of a file: of a xacro template what the program `xacro` makes of it, where that is on the PATH.
/// @throws Error (file_system) if it cannot be read; (input) if xacro cannot expand it
std::string urdf_text(const std::string& path);

/// Reads a URDF file, or a xacro template (`urdf_text`), with urdfdom, after strict checks of its text,
/// numbers and tree.
/// @throws Error (input) with file, line and column if it is not a valid kinematic tree; (file_system) if it
/// cannot be read
RobotModel read_urdf(const std::string& path);

/// Reads the text of a URDF; `file` is the name used in messages.
RobotModel parse_urdf(const std::string& text, const std::string& file);

/// The robot that a spec names, and its chain with the tool.
struct RobotOfSpec {
  RobotModel robot;
  Chain chain;
  std::vector<std::string> warnings;
};

/// Reads the section `robot` of a spec alone.
/// @param path  name of the file, to which its own paths are relative
/// @throws Error (input)
RobotOfSpec robot_of_spec(const std::string& text, const std::string& path);

/// The chain that a first spec describes: from `base` to `tip` where they are given, else to the end of the
/// tree that is the likeliest tip (`tree_ends`) and can be used.
/// @throws Error (input) if no chain of the robot can be used, or no joint moves
Chain first_chain(const RobotModel&, const std::string& base = "", const std::string& tip = "");

/// A commented spec of the chain that can be analyzed as it is.
///
/// Encoders, and ranges of joints that have none, are assumed and marked `ASSUMED`; a ratio that the URDF
/// states is the gear ratio of an assumed motor encoder.
/// @param urdf  path of the URDF relative to the spec
std::string first_spec(const RobotModel&, const Chain&, const std::string& urdf);

/// The text of the spec's URDF with the link dimensions of effects `geometry`, stated and found: each moves
/// the <origin> of its joint in the frame of the parent link. All else is as in the file.
/// @throws Error (input) where the robot is not from a URDF, or the file cannot be read
/// @param found  beside those that the spec states
std::string urdf_as_built(const Spec&, const std::vector<Effect>& found);

}  // namespace qerr
