#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "problem.hpp"

namespace qerr::bench {

/// What is done with every configuration; each stage does what the one before does, too.
enum class Stage {
  jac,  ///< tip Jacobian J, 6 x independent joints, linear rows first, base axes
  job,  ///< worst case 0.5 |J C| Delta (6) and covariance (J C) diag(Delta^2/12) (J C)^T (its 21 entries)
  full  ///< statistics of worst case and sigma of the six coordinates
};
inline constexpr std::array stages{Stage::jac, Stage::job, Stage::full};
inline constexpr std::array stage_names{"jac", "job", "full"};

/// Entries (row, column <= row) of a covariance, row by row.
inline constexpr int covariance_entries = 21;

/// Of one figure over all configurations. Quantiles may come from a histogram whose bins are 1 % wide.
struct Summary {
  double max = 0, mean = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the configuration that has the maximum
};
/// Of the worst cases of the six coordinates, then of their sigmas; empty below `full`.
using Summaries = std::vector<Summary>;

/// What a contestant computed for each configuration (a column); filled where one is given, to be compared.
struct Recording {
  Eigen::MatrixXd jacobians;    ///< 6 n x configurations, column-major matrices
  Eigen::MatrixXd worst_cases;  ///< 6 x configurations
  Eigen::MatrixXd covariances;  ///< 21 x configurations

  Recording(Stage stage, Eigen::Index joints, Eigen::Index count)
      : jacobians(6 * joints, count),
        worst_cases(stage == Stage::jac ? 0 : 6, count),
        covariances(stage == Stage::jac ? 0 : covariance_entries, count) {}
};

/// Does a stage for the problem's first `count` configurations, on the calling thread.
using Run = std::function<Summaries(Stage, std::uint64_t count, Recording*)>;

/// One row of the benchmark: who, how it was built, and how it gets to work.
struct Contestant {
  std::string name;
  std::string built;  ///< version and compiler flags
  std::function<Run(const Problem&)> prepare;
  bool whole_job_only = false;       ///< does `full` alone, and shows no single configuration
  bool draws_itself = false;         ///< does any number of configurations, not only those of Problem::points
  std::string instruction_set = {};  ///< of a vectorized one: `portable`, `avx2` or `avx512`
  /// Operations per configuration that need the FMA pipes (fused, multiplications, and additions where the
  /// machine has no others), counted; empty: unknown.
  std::function<double(const Problem&, Stage)> fma_pipe_operations = {};

  bool does(Stage stage) const { return !whole_job_only || stage == Stage::full; }
  bool own() const { return name.starts_with("qerr"); }
};

/// Every contestant that this machine can run; the first is the reference that the others must agree with.
std::vector<Contestant> contestants();

/// Makes the compiler believe that somebody looks at these numbers.
inline void observe(const void* numbers) { asm volatile("" : : "r"(numbers) : "memory"); }

}  // namespace qerr::bench
