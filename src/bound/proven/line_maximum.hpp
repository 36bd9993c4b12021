#pragma once

#include <Eigen/Core>
#include <functional>

#include "qerr/kinematics/robot_model.hpp"

/// Maxima along one joint.
namespace qerr {

/// a_g + b_g cos(t) + c_g sin(t), one row a term: columns a, b, c.
using Harmonics = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// The harmonics from the values at t = 0, 2 pi/3 and -2 pi/3.
Harmonics harmonics(const Eigen::VectorXd& at_0, const Eigen::VectorXd& at_plus,
                    const Eigen::VectorXd& at_minus);

/// t in the range that maximizes sum_g |a_g + b_g cos t + c_g sin t|.
///
/// Between two zeros of its terms the sum is a harmonic itself, whose maximum is known; a zero of a term is
/// no maximum, as the magnitude is convex there.
double argmax_of_magnitudes(const Harmonics&, const Limits& range);

/// t in the range that maximizes sum_g (a_g + b_g cos t + c_g sin t)^2, a trigonometric polynomial of degree
/// 2: the best of its stationary points, between 64 samples, and of the ends.
double argmax_of_squares(const Harmonics&, const Limits& range);

/// t in the range near which f is largest: of `samples` equally spaced values the three highest peaks
/// are refined by golden sections.
double argmax_by_search(const std::function<double(double)>& f, const Limits& range, int samples);

}  // namespace qerr
