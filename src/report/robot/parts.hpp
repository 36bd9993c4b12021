#pragma once

#include <string>
#include <vector>

#include "qerr/report/robot_report.hpp"
#include "report/rows.hpp"
#include "report/text_table.hpp"

/// Parts of the table of `qerr robot`.
namespace qerr {

/// The tree: a line for each moving joint with the link that it moves and what is fixed to that link.
std::string tree_text(const RobotReport&, std::size_t width);

/// The moving joints with axis, range, effort, velocity and stated ratio; then the mimics.
std::string joint_text(const RobotReport&, std::size_t width);

/// Roll, pitch and yaw of a rotation R_z(yaw) R_y(pitch) R_x(roll); at the gimbal lock roll is 0.
std::vector<double> roll_pitch_yaw(const Eigen::Matrix3d&);

RowsOf<Joint> rows(Of<Joint>);

}  // namespace qerr
