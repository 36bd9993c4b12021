#pragma once

#include "bound/proven/error_terms.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// Result of branch and bound.
struct SearchedMaximum {
  double upper = 0;    ///< of the figure over the box of the ranges, rounding included
  Eigen::VectorXd at;  ///< center of a box with the largest value among all centers
};

/// Upper bound of a figure over the box of the joint ranges: the box with the largest bound (box_bound.hpp)
/// is halved along the joint that contributes most to it, until no bound exceeds `known_lower` (1 + gap), or
/// `boxes` boxes were bounded.
/// @param known_lower  a value that the figure has in the box
SearchedMaximum branch_and_bound(const ErrorTerms&, const std::vector<Limits>& ranges, double known_lower,
                                 double gap, std::size_t boxes);

/// Number of boxes for a gap: 131072 at 1 %, in proportion to 1/gap, at most 2^21. About 5 us each.
std::size_t boxes_of_gap(double gap);

/// Allowance for the rounding of the figure itself, as `operational_error` and `workspace` compute it
/// (box_bound.hpp).
double rounding_allowance(const ErrorTerms&, const std::vector<Limits>& ranges);

/// Joints on which the figure depends.
std::size_t influential_joints(const ErrorTerms&, const std::vector<Limits>& ranges);

}  // namespace qerr
