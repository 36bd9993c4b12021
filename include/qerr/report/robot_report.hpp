#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"
#include "qerr/kinematics/tree_ends.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// What a URDF holds, as `qerr robot` shows it.
struct RobotReport {
  RobotModel robot;
  std::string sha256;              ///< of the URDF's bytes
  std::vector<std::string> roots;  ///< links without a parent; one in a sound URDF
  std::vector<TreeEnd> ends;       ///< the likeliest tips first
  /// Base and tip of the first spec; empty if no chain can be used.
  std::string base, tip;
  std::string obstacle;   ///< why none can be used; empty otherwise
  std::string spec_file;  ///< to which the first spec was written; empty: it was not
};

/// @param base, tip  of the first spec; empty: chosen by `first_chain`
/// @throws Error (input) if a base or tip that is given cannot be used
RobotReport robot_report(RobotModel, const std::string& text, const std::string& base = "",
                         const std::string& tip = "");

}  // namespace qerr
