#pragma once

#include <string>
#include <vector>

#include "qerr/report/robot_report.hpp"
#include "report/text_table.hpp"

/// Parts of the table of `qerr robot`.
namespace qerr {

inline constexpr std::size_t robot_table_width = 80;

/// A name cut in its middle to at most `width` columns.
std::string fitted(const std::string& name, std::size_t width);

/// The tree: a line for each moving joint with the link that it moves and what is fixed to that link.
std::string tree_text(const RobotReport&);

/// The moving joints with axis, range, effort, velocity and stated ratio; then the mimics.
std::string joint_text(const RobotReport&);

}  // namespace qerr
