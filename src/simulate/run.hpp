#pragma once

#include <functional>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/path_errors.hpp"
#include "simulate/run_statistics.hpp"

namespace qerr {

/// Largest bounds over the samples of a motion, those of the settling included, since a filter has a memory.
struct BoundsAlongPath {
  Eigen::VectorXd rigorous;  ///< of the position error
  /// Of its difference from the mean error at the centre. A filter multiplies the mean by |H(1)| and the
  /// bound of the difference by its l1 norm.
  Eigen::VectorXd deviation;

  void include(const BoundsAlongPath&);
};

/// Theory of one coordinate after one filter; the members are those of `SimulatedSignal`.
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, worst_case = 0, worst_case_path = 0;
};

/// Theory of all signals but sigma_exact.
/// @param middle   error at the centre of the motion
/// @param squares  [coordinate]: mean of sum (J C Delta)^2 over the path
/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle,
                                                         const std::vector<Norms>&,
                                                         const Eigen::VectorXd& squares,
                                                         const BoundsAlongPath&);

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

/// Displacement of each encoder in a run by a fraction of a count, where the options ask for it: uniform, and
/// independent of all other runs, so that their scatter is that of their mean.
Eigen::VectorXd displacement_of_run(const Transmission&, const SimulationOptions&, std::uint64_t run);

/// A filter uses every n-th sample of the motion.
/// @throws Error (input; key `motion.sample_rate`) if its rate does not divide that of the motion
std::uint64_t divisor_of(const Filter&, const Motion&);

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
