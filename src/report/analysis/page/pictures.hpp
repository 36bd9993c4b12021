#pragma once

#include <string>

#include "qerr/report/analysis.hpp"
#include "report/analysis/page/sample.hpp"

namespace qerr {

/// Pictures of the page of `analyze`, as markup.

/// Each encoder's share: of the tip's position (`encoder_budget`), and of the variance and of the worst case
/// of each coordinate, one to be chosen.
std::string budget_figures(const Analysis&);

/// The largest worst case of each coordinate by the position of the tip, one coordinate to be chosen.
std::string workspace_figures(const Analysis&, const ConfigurationSample&);

/// The distribution of every bound, one quantity to be chosen, with limits required of them and proven
/// maxima.
std::string distribution_figures(const Analysis&, const ConfigurationSample&);

/// The robot where the trace of the position's covariance is largest, and where it is the median of the
/// sample, with the ellipsoid of one sigma and the box of the worst case at the tip, in three views each.
std::string robot_figures(const Analysis&, const ConfigurationSample&);

}  // namespace qerr
