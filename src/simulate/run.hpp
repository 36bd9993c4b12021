#pragma once

#include <functional>
#include <vector>

#include "qerr/simulate/simulate.hpp"
#include "simulate/channels.hpp"
#include "simulate/run_statistics.hpp"
#include "simulate/theory_along_path.hpp"

namespace qerr {

/// Input of all runs of a simulation. Borrows its references, which must outlive it.
struct Job {
  const OperationalModel& model;
  const std::vector<Filter>& filters;
  const Motion& motion;
  const std::vector<Effect>& effects;
  const SimulationOptions& options;
  std::vector<std::uint64_t> every;  ///< [filter]: it uses every n-th sample of the motion
  std::uint64_t samples, settling, blocks;
  Eigen::VectorXd mean;     ///< of the error at the centre of the motion
  bool every_zero = false;  ///< displace the runs by equal steps over a whole count instead
};

/// Result of runs that are simulated together: statistics of each, and theory at the samples of all.
struct RunsResult {
  std::vector<std::vector<RunStatistics>> outputs;  ///< [run][0: position, then the filters]
  BoundsAlongPath bounds;
  std::vector<ErrorTrace> traces;  ///< [0: position, then the filters]; of the first run alone
};

/// Simulates runs first .. first + count - 1 together, batch by batch, since all of them share the path of
/// the joints.
/// @param tick  called after every `tick_samples` of every run
RunsResult run_together(const Job&, std::uint64_t first, std::size_t count,
                        const std::function<void()>& tick);

inline constexpr std::uint64_t tick_samples = 4096;

}  // namespace qerr
