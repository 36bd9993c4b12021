#pragma once

#include <string>

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

}  // namespace qerr
