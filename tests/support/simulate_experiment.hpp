#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "qerr/simulate/simulate.hpp"

/// The input of a simulation: a robot, filters and a motion.
namespace qerr::testing {

struct Experiment {
  OperationalModel model;
  std::vector<Filter> filters;
  std::vector<Norms> norms;
  Motion motion;
};

/// By default one run without random phases, which would displace the path.
inline Simulation run(const Experiment& e, const SimulationOptions& options = {}) {
  return simulate(e.model, e.filters, e.norms, e.motion, {}, options);
}

/// Expects bitwise equality.
inline void expect_same(const Simulation& a, const Simulation& b) {
  for (std::size_t f = 0; f < a.results.size(); ++f)
    for (std::size_t c = 0; c < a.results[f].size(); ++c) {
      const SimulatedSignal &x = a.results[f][c], &y = b.results[f][c];
      EXPECT_EQ(x.sigma_simulated, y.sigma_simulated);
      EXPECT_EQ(x.sigma_lower, y.sigma_lower);
      EXPECT_EQ(x.peak_simulated, y.peak_simulated);
      EXPECT_EQ(x.mean_simulated, y.mean_simulated);
      EXPECT_EQ(x.ladder.correlated_joints, y.ladder.correlated_joints);
      EXPECT_EQ(x.worst_case_path, y.worst_case_path);
      EXPECT_EQ(x.sigma_exact, y.sigma_exact);
      EXPECT_EQ(x.sigma_upper, y.sigma_upper);
      EXPECT_EQ(x.ladder.nonlinear, y.ladder.nonlinear);
    }
}

}  // namespace qerr::testing
