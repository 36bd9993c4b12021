#pragma once

#include <vector>

#include "qerr/simulate/simulate.hpp"

/// A robot, what filters its readings, and how it moves: what a simulation is asked of.
namespace qerr::testing {

struct Experiment {
  OperationalModel model;
  std::vector<Filter> filters;
  std::vector<Norms> norms;
  Motion motion;
};

/// By default one run with no phases drawn, which would displace the path.
inline Simulation run(const Experiment& e, const SimulationOptions& options = {}) {
  return simulate(e.model, e.filters, e.norms, e.motion, {}, options);
}

}  // namespace qerr::testing
