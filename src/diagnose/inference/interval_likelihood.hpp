#pragma once

#include <Eigen/Core>

namespace qerr {

/// What quantized readings say of a deviation from the reference path: between which edges it lay.
struct Intervals {
  Eigen::ArrayXd lower, upper;  ///< edges of every reading less its path, lower < upper [rad or m]
};

/// Log-likelihood of deviations x from the reference under readings, and its derivatives.
///
/// A deviation that is known but for a Gaussian of `sigma` falls between the edges with the probability
/// P = Phi((upper - x)/sigma) - Phi((lower - x)/sigma). log P is concave in x, and in x/sigma and 1/sigma
/// together (Burridge 1981): fits that are linear in their parameters have one optimum, and Newton's method
/// finds it. Far outside of the interval it is the Gaussian's own tail and does not underflow.
struct IntervalLikelihood {
  double log_likelihood = 0;
  Eigen::ArrayXd score;      ///< d log P / dx, per reading
  Eigen::ArrayXd curvature;  ///< -d^2 log P / dx^2 >= 0, per reading
  double outliers = 0;       ///< readings that are taken to be such, as a sum of probabilities
  // With a common factor of all sigma, in the coordinates u = x/factor and w = 1/factor, at factor 1:
  double scale_score = 0;      ///< d log P / dw, summed
  double scale_curvature = 0;  ///< -d^2 log P / dw^2, summed
  Eigen::ArrayXd cross;        ///< -d^2 log P / du dw, per reading
};

/// Part of the readings that fits and judgements take to be outliers.
inline constexpr double outlier_part = 0.01;

/// @param x         deviations
/// @param sigma     one per reading, or one for all
/// @param outliers  part of the readings that may be anything within `spread`, which then has
///   P = (1 - outliers) P + outliers * width/spread: some samples about a reversal, say, of which the path
///   does not tell on which side they were. Derivatives are those of the readings that are none.
IntervalLikelihood interval_likelihood(const Intervals&, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma,
                                       double outliers = 0, double spread = 1);

}  // namespace qerr
