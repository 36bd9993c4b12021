#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/statistic.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

/// A coordinate's bounds over the configurations [m or rad].
struct CoordinateStatistics {
  Statistic worst_case, worst_case_rigorous, sigma;
  Eigen::VectorXd share;  ///< each encoder's part of the variance, a_i Delta_i^2/12 over its sum, averaged
  Eigen::VectorXd
      share_worst_case;  ///< each encoder's part of the worst case, |J C|_i Delta_i over its sum, averaged
                         ///< (in both with what the sources of its encoder and joint add)
};

/// A filtered coordinate's bounds over the configurations [m/s, rad/s, ...].
struct DerivativeStatistics {
  Statistic worst_case, sigma;
  std::optional<Statistic> sigma_in_motion;  ///< with the encoders' speeds instead of IPQN
};

/// Everything that `analyze` says about the sampled configurations.
struct Workspace {
  std::uint64_t count = 0;
  std::vector<CoordinateStatistics> coordinates;
  std::vector<std::vector<DerivativeStatistics>> derivatives;  ///< [filter][coordinate]
  Eigen::MatrixXd mean_variance_parts;  ///< coordinates x encoders: each encoder's mean part of the variance
  Eigen::MatrixXd mean_covariance;      ///< of all coordinates, averaged over the configurations
  Eigen::MatrixXd covariance_at_largest;  ///< where the trace of the position's covariance is largest
  Eigen::VectorXd largest_at;             ///< that configuration [rad or m]
  /// [filter]: both covariances behind it, where sources with gains of their own make them more than
  /// ||H||_2^2 times those; empty without sources.
  struct Filtered {
    Eigen::MatrixXd mean_covariance, covariance_at_largest;
  };
  std::vector<Filtered> filtered;
  Eigen::VectorXd
      largest_arms;  ///< of each encoder: largest |entry| of the position's rows of J C [m/rad or 1]
  double smallest_cosine_of_pitch = 1;
  bool exact_percentiles = true;
};

struct ConfigurationBatch;

struct WorkspaceOptions {
  unsigned threads = 0;  ///< 0: one per core; the result does not depend on it
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  /// Text about a batch, called on any thread, and what receives all texts, one after the other in the order
  /// of the configurations.
  std::function<std::string(const ConfigurationBatch&)> text = {};
  std::function<void(const std::string&)> write = {};
  /// [filter]: sigma of each encoder's error behind the filter in a motion, in quantization intervals
  /// (noise_along_motion.hpp); empty where it is not known.
  std::vector<Eigen::VectorXd> noise_in_motion = {};
  /// Worst case and sigma alone: neither the rigorous bound nor what each encoder contributes, nor where the
  /// position's variance is largest.
  bool brief = false;
  InstructionSet instructions = instruction_set();
};

/// Statistics of all bounds over the configurations.
///
/// Memory does not grow with their number beyond `exact_percentiles_limit`. Blocks of configurations are
/// summed and joined in a fixed order: the same bytes for any number of threads.
/// @param filters  norms of the derivative filters, one set of derivative statistics each
/// @throws Error (input; key `configurations`) when a joint turns beyond 2^20 rad
Workspace workspace(const OperationalModel&, const std::vector<Norms>& filters, const Configurations&,
                    const WorkspaceOptions& = {});

/// Whether the noise of a filter's encoders is among those of WorkspaceOptions::noise_in_motion.
inline bool is_known(const std::vector<Eigen::VectorXd>& noise_in_motion, std::size_t filter) {
  return filter < noise_in_motion.size() && noise_in_motion[filter].size() > 0;
}

}  // namespace qerr
