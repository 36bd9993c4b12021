#pragma once

#include <string>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// Reads a URDF file with urdfdom, after strict checks of its text, numbers and tree.
/// @throws Error (input) with file, line and column if it is not a valid kinematic tree; (file_system) if it
/// cannot be read
RobotModel read_urdf(const std::string& path);

/// Reads the text of a URDF; `file` is the name used in messages.
RobotModel parse_urdf(const std::string& text, const std::string& file);

}  // namespace qerr
