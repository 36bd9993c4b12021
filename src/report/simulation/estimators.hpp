#pragma once

#include <string>

#include "qerr/report/simulation_report.hpp"
#include "report/rows.hpp"

namespace qerr {

/// The ranking of `simulate --estimators`: a row for each estimate, of each joint the best first.
std::string estimator_table(const SimulationReport&, const Style&);

/// Error against speed of each joint's estimates, and the ranking.
std::string estimator_figures(const SimulationReport&);

std::string estimator_csv(const SimulationReport&);

/// `rad/s` or `m/s`.
std::string speed_unit(const SimulationReport&, const EstimatedVelocity&);

}  // namespace qerr
