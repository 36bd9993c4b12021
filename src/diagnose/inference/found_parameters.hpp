#pragma once

#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// The parameters of every term of a fitted explanation, each with its 95 % interval.
///
/// The covariance of all coefficients and shapes is V = H^-1 M H^-1 ("sandwich"): H is the curvature of the
/// interval likelihood, M the scatter of its score from block to block, so that what is left may be
/// correlated within a block. Where H^-1 alone gives more, as with few blocks, that holds. Amplitudes and
/// phases follow by their derivatives. A lost count's moment lies between the readings among which the
/// likelihood falls by less than 1.92. What was chosen and not fitted, such as a whole order, has an interval
/// without width.
/// @param e  what the explanation was fitted to
std::vector<std::vector<FoundParameter>> found_parameters(const Evidence& e, const Explanation&);

}  // namespace qerr
