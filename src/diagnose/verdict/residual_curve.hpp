#pragma once

#include "diagnose/inference/explanation.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// The residual without one term of a fitted model, in bins of the quantity that the term depends on: the one
/// of angle, speed, time, effort, temperature and (of a periodic term) angle within its period of which its
/// addition varies least within a bin.
ResidualCurve residual_curve(const Evidence&, const Explanation&, std::size_t term);

}  // namespace qerr
