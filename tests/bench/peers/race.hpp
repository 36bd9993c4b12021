#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "check.hpp"
#include "fma_peak.hpp"

namespace qerr::bench {

/// Rate over several rounds.
struct Rate {
  double best = 0, median = 0;  ///< [1/s]
};

struct ContestantResult {
  std::string name, built, instruction_set;
  bool own = false;
  Deviation deviation;
  std::array<std::optional<Rate>, stages.size()> rates;  ///< configurations per second of CPU time
  /// Counted operations times the best rate, over the best peak of its instruction set; empty: not counted.
  std::array<std::optional<double>, stages.size()> fraction_of_bound, fma_pipe_operations;
};

/// Speed-up of workspace() with two threads, by wall time, in the best round of each.
struct TwoThreads {
  double ratio = 0;  ///< time of one over time of two
  double cores = 0;  ///< CPU time over wall time of the two threads: below 2 if other processes run
};

struct ProblemResult {
  std::string name;
  Eigen::Index joints = 0;
  std::vector<ContestantResult> contestants;
  std::optional<TwoThreads> two_threads;  ///< empty on one core
};

struct PeakResult {
  FmaPeak peak;
  Rate rate;  ///< multiply-add instructions per second
};

struct Results {
  std::vector<ProblemResult> problems;
  std::vector<PeakResult> peaks;
};

struct RaceOptions {
  unsigned rounds = 7;
  double slice = 0.1;  ///< CPU time of each contestant, robot and stage in a round [s]
};

/// Times everything in interleaved rounds, so that disturbances of the machine affect all contestants.
/// @param results  the problems with their contestants and deviations, whose rates are filled in
void race(const std::vector<Problem>&, const std::vector<Contestant>&, const RaceOptions&, Results& results);

}  // namespace qerr::bench
