#pragma once

#include <Eigen/Core>

namespace qerr {

/// What quantized readings say of a position: between which edges it lay when it was read.
struct Intervals {
  Eigen::ArrayXd lower, upper;  ///< of every reading, lower < upper [the position's unit]
};

/// Log-likelihood of positions x under readings, and its derivatives.
///
/// A position that is known but for a Gaussian of `sigma` falls between the edges with the probability
/// P = Phi((upper - x)/sigma) - Phi((lower - x)/sigma). log P is concave in x: fits that are linear in their
/// parameters have one optimum. Far outside of the interval it is the Gaussian's own tail and does not
/// underflow.
struct IntervalLikelihood {
  double log_likelihood = 0;
  Eigen::ArrayXd score;      ///< d log P / dx, per reading
  Eigen::ArrayXd curvature;  ///< -d^2 log P / dx^2 >= 0, per reading
  double scale_score = 0;    ///< d log-likelihood / d log sigma
};

/// @param x      positions
/// @param sigma  one per reading, or one for all
IntervalLikelihood interval_likelihood(const Intervals&, const Eigen::ArrayXd& x,
                                       const Eigen::ArrayXd& sigma);

/// Only the sum of log P.
double log_likelihood(const Intervals&, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma);

}  // namespace qerr
