#pragma once

#include <string>

#include "qerr/report/analysis.hpp"

/// Pictures of the page of `analyze`, as markup.
namespace qerr {

/// Each encoder's share: of the tip's position (`encoder_budget`), and of the variance and of the worst case
/// of each coordinate, one to be chosen.
std::string budget_figures(const Analysis&);

/// Percentiles of every bound, one quantity to be chosen, with limits required of them and proven maxima.
std::string distribution_figures(const Analysis&);

/// The robot where the trace of the position's covariance is largest, with the ellipsoid of one sigma at the
/// tip, in three views; a sentence without x, y and z.
std::string robot_figures(const Analysis&);

}  // namespace qerr
