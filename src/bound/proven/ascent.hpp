#pragma once

#include <vector>

#include "bound/proven/error_terms.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// A local maximum of the figure over the box that is not below that at `start`: each joint in turn is moved
/// to the best place along its range, until the figure no longer grows by 1e-12 of itself.
///
/// Along one axis that turns the figure's terms are harmonics (line_maximum.hpp); a longest corner is that of
/// the corner which is longest at present, whose square is one of a variance. Along a prismatic axis a figure
/// is convex: its maximum is at an end. Joints that move several axes are searched.
Eigen::VectorXd ascend(const ErrorTerms&, const std::vector<Limits>& ranges, Eigen::VectorXd start);

}  // namespace qerr
