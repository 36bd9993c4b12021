#pragma once

#include <functional>
#include <vector>

#include "channels.hpp"
#include "qerr/simulate/simulate.hpp"
#include "run_statistics.hpp"
#include "theory_along_path.hpp"

namespace qerr {

/// What all runs of a simulation share.
struct Job {
  const OperationalModel& model;
  const std::vector<Filter>& filters;
  const Motion& motion;
  const std::vector<Effect>& effects;
  const SimulationOptions& options;
  std::vector<std::uint64_t> every;  ///< [filter]: of how many samples of the motion it takes one
  std::uint64_t samples, settling, blocks;
  Eigen::VectorXd mean;  ///< of the error at the centre of the motion
};

/// What one run gives: statistics of the position, then of the filters, and theory at its samples.
struct RunResult {
  std::vector<RunStatistics> outputs;
  AlongPath path;
};

/// @param tick  called after every `tick_samples`
RunResult run(const Job&, std::uint64_t index, const std::function<void()>& tick);

inline constexpr std::uint64_t tick_samples = 4096;

}  // namespace qerr
