#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "problem.hpp"

namespace qerr::bench {

/// What is computed for every configuration; each stage includes the previous one.
enum class Stage {
  jac,  ///< tip Jacobian J, 6 x independent joints, linear rows first, base axes
  job,  ///< worst case 0.5 |J C| Delta (6) and covariance (J C) diag(Delta^2/12) (J C)^T (its 21 entries)
  full  ///< statistics of worst case and sigma of the six coordinates
};
inline constexpr std::array stages{Stage::jac, Stage::job, Stage::full};
inline constexpr std::array stage_names{"jac", "job", "full"};

/// Entries (row, column <= row) of a covariance, row by row.
inline constexpr int covariance_entries = 21;

/// Statistics of one figure over all configurations. Quantiles may be from a histogram with bins of 1 %.
struct Summary {
  double max = 0, mean = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the configuration of the maximum
};
/// Statistics of the worst cases of the six coordinates, then of their sigmas; empty below `full`.
using Summaries = std::vector<Summary>;

/// Results of a contestant for each configuration (a column), for the comparison.
struct Recording {
  Eigen::MatrixXd jacobians;    ///< 6 n x configurations, column-major matrices
  Eigen::MatrixXd worst_cases;  ///< 6 x configurations
  Eigen::MatrixXd covariances;  ///< 21 x configurations

  Recording(Stage stage, Eigen::Index joints, Eigen::Index count)
      : jacobians(6 * joints, count),
        worst_cases(stage == Stage::jac ? 0 : 6, count),
        covariances(stage == Stage::jac ? 0 : covariance_entries, count) {}
};

/// Runs a stage for the problem's first `count` configurations, on the calling thread.
using Run = std::function<Summaries(Stage, std::uint64_t count, Recording*)>;

/// One row of the benchmark: name, build, and factory of its job.
struct Contestant {
  std::string name;
  std::string built;  ///< version and compiler flags
  std::function<Run(const Problem&)> prepare;
  bool whole_job_only = false;  ///< supports `full` only, and outputs no single configuration
  bool draws_itself = false;    ///< samples any number of configurations itself instead of Problem::points
  std::string instruction_set = {};  ///< of a vectorized contestant: `portable`, `avx2` or `avx512`
  /// Counted operations per configuration that need the FMA pipes (fused multiply-adds, multiplications, and
  /// additions if the processor has no separate adders); empty: unknown.
  std::function<double(const Problem&, Stage)> fma_pipe_operations = {};

  bool does(Stage stage) const { return !whole_job_only || stage == Stage::full; }
  bool own() const { return name.starts_with("qerr"); }
};

/// Every contestant that this machine can run; the first is the reference of the comparison.
std::vector<Contestant> contestants();

/// Prevents the compiler from removing the computation of these numbers.
inline void observe(const void* numbers) { asm volatile("" : : "r"(numbers) : "memory"); }

}  // namespace qerr::bench
