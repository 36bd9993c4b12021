#pragma once

#include <functional>
#include <vector>

#include "qerr/simulate/simulate.hpp"
#include "simulate/channels.hpp"
#include "simulate/run_statistics.hpp"
#include "simulate/theory_along_path.hpp"

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
  std::size_t stretches;  ///< of the path (AlongPath)
  Eigen::VectorXd mean;   ///< of the error at the centre of the motion
  double spread;          ///< of the runs' displacements (even_spread)
};

/// x^(n+1) = x + 1: the powers of 1/x make the most even additive sequence in n dimensions (Roberts 2018).
double even_spread(Eigen::Index dimensions);

/// What runs give that go side by side: statistics of each, and theory at the samples of all.
struct RunsResult {
  std::vector<std::vector<RunStatistics>> outputs;  ///< [run][0: position, then the filters]
  AlongPath path;
};

/// Runs first .. first + count - 1, a batch of samples of each after the other: the joints' path is the same
/// for all of them.
/// @param tick  called after every `tick_samples` of every run
RunsResult run_together(const Job&, std::uint64_t first, std::size_t count,
                        const std::function<void()>& tick);

inline constexpr std::uint64_t tick_samples = 4096;

}  // namespace qerr
