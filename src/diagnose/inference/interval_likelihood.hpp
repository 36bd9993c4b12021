#pragma once

#include <Eigen/Core>

namespace qerr {

/// Intervals of the deviation from the reference path that are consistent with quantized readings.
struct Intervals {
  Eigen::ArrayXd lower, upper;  ///< edges of every reading less its path, lower < upper [rad or m]
};

/// Log-likelihood of deviations x from the reference under readings, and its derivatives.
///
/// A deviation x with Gaussian noise of standard deviation `sigma` is between the edges with the probability
/// P = Phi((upper - x)/sigma) - Phi((lower - x)/sigma). log P is concave in x, and in x/sigma and 1/sigma
/// together (Burridge 1981): fits that are linear in their parameters have a single optimum, which Newton's
/// method finds. Far outside of the interval the asymptotic tail is used, which does not underflow.
struct IntervalLikelihood {
  double log_likelihood = 0;
  Eigen::ArrayXd score;      ///< d log P / dx, per reading
  Eigen::ArrayXd curvature;  ///< -d^2 log P / dx^2 >= 0, per reading
  double outliers = 0;       ///< expected number of outliers: sum of the posterior probabilities
  // With a common factor of all sigma, in the coordinates u = x/factor and w = 1/factor, at factor 1:
  double scale_score = 0;      ///< d log P / dw, summed
  double scale_curvature = 0;  ///< -d^2 log P / dw^2, summed
  Eigen::ArrayXd cross;        ///< -d^2 log P / du dw, per reading
};

/// Prior probability of an outlier in fits and tests (convention).
inline constexpr double outlier_part = 0.01;

/// @param x         deviations
/// @param sigma     one per reading, or one for all
/// @param outliers  fraction of readings that are uniform over `spread`, such as samples about a reversal of
///   which the side of the backlash is unknown. The probability of a reading is then
///   (1 - outliers) P + outliers * width/spread; the derivatives are those of the inliers, weighted by their
///   posterior probability.
IntervalLikelihood interval_likelihood(const Intervals&, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma,
                                       double outliers = 0, double spread = 1);

}  // namespace qerr
