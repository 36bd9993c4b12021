#pragma once

#include <Eigen/Core>
#include <vector>

namespace qerr {

/// |sum_k score_k e^{i n spacing argument_k}|^2 for n = first .. last.
///
/// The scores are spread over an even grid of arguments by a cubic B-spline, the grid is transformed, and the
/// transform of the spline is divided out. Source: Dutt and Rokhlin, "Fast Fourier transforms for
/// nonequispaced data", SIAM Journal on Scientific Computing 14 (1993), with a spline for their Gaussian. The
/// error is below 3 % of the largest power.
/// @param argument  from 0 to pi/(2 spacing) at most
std::vector<float> periodogram(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double spacing,
                               Eigen::Index first, Eigen::Index last);

/// The power at one rate, by its sum.
double power_at(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate);

}  // namespace qerr
