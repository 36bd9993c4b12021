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
  double outliers = 0;       ///< readings that are taken to be such, as a sum of probabilities
  double scale_score = 0;    ///< d log-likelihood / d log sigma
};

/// @param x         positions
/// @param sigma     one per reading, or one for all
/// @param outliers  part of the readings that may be anything within `spread`, which then has
///   P = (1 - outliers) P + outliers * width/spread: some samples about a reversal, say, of which the path
///   does not tell on which side they were
IntervalLikelihood interval_likelihood(const Intervals&, const Eigen::ArrayXd& x, const Eigen::ArrayXd& sigma,
                                       double outliers = 0, double spread = 1);

}  // namespace qerr
