#pragma once

#include <string>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// Reads a URDF file through urdfdom, after and before checks of our own for what urdfdom 3.0.1 lets pass.
/// @throws Error (input) with file, line and column for anything that is not a valid tree; (file_system) if
/// unreadable
RobotModel read_urdf(const std::string& path);

/// The same from text; `file` is only the name used in messages.
RobotModel parse_urdf(const std::string& text, const std::string& file);

}  // namespace qerr
