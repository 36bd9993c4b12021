#pragma once

#include <string>

namespace qerr {

/// The file that `robot.urdf` names: a path relative to the folder of the spec, or `package://PKG/PATH`,
/// looked up in the ROS packages of AMENT_PREFIX_PATH (`share/PKG`) and ROS_PACKAGE_PATH, or `file://PATH`.
/// @throws Error (input, without a place) for an unknown scheme or a package that is not found
std::string urdf_path(const std::string& given, const std::string& folder);

}  // namespace qerr
