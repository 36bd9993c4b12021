#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "qerr/bound/derivative_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/statistic.hpp"
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
  double largest_arm = 0;  ///< largest |entry| of the position's rows of J over the samples [m/rad or 1]
  double smallest_cosine_of_pitch = 1;
  bool exact_percentiles = true;
};

/// Called in order with the index of the first configuration of a block, the configurations (columns) and
/// their errors.
using BlockVisitor =
    std::function<void(std::uint64_t first, const Eigen::MatrixXd&, const std::vector<OperationalError>&)>;

struct WorkspaceOptions {
  unsigned threads = 0;  ///< 0: one per core; the result does not depend on it
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  BlockVisitor visit = {};
  /// [filter]: sigma of each encoder's error behind the filter in a motion, in quantization intervals
  /// (noise_along_motion.hpp); empty where it is not known.
  std::vector<Eigen::VectorXd> noise_in_motion = {};
};

/// Statistics of all bounds over the configurations; summed in fixed blocks in a fixed order.
/// @param filters  norms of the derivative filters, one set of derivative statistics each
Workspace workspace(const OperationalModel&, const std::vector<Norms>& filters, const Configurations&,
                    const WorkspaceOptions& = {});

/// Whether the noise of a filter's encoders is among those of WorkspaceOptions::noise_in_motion.
inline bool is_known(const std::vector<Eigen::VectorXd>& noise_in_motion, std::size_t filter) {
  return filter < noise_in_motion.size() && noise_in_motion[filter].size() > 0;
}

/// sqrt(sum_i (J C Delta)_ji^2 noise_i^2), j = coordinate: IPQN with each encoder's own noise behind a
/// filter; and what the sources add.
/// @param gains  of `gains_behind`
double sigma_in_motion(const OperationalError&, Eigen::Index coordinate, const Eigen::VectorXd& noise,
                       const Eigen::VectorXd& gains);

/// A statistic times a non-negative factor.
Statistic scaled(const Statistic&, double factor);

}  // namespace qerr
