#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

/// Bounds of a coordinate over the configurations [m or rad].
struct CoordinateStatistics {
  Statistic worst_case, worst_case_rigorous, sigma;
  /// [encoder]: mean over the configurations of its fraction of the variance (J C)_i^2 Delta_i^2/12, and of
  /// the worst case |J C|_i Delta_i / 2, each with the sources attributed to the encoder. Empty for a length,
  /// or a signal of another kind.
  Eigen::VectorXd share, share_worst_case;
};

/// Bounds of a filtered coordinate over the configurations [m/s, rad/s, ...].
struct DerivativeStatistics {
  Statistic worst_case;
  std::optional<Statistic> sigma;            ///< empty: the spectrum of an error source is not known
  std::optional<Statistic> sigma_in_motion;  ///< with the encoders' speeds instead of IPQN
  /// Of the quantization alone, where there are other errors; empty without: then `sigma` is that.
  std::optional<Statistic> sigma_quantization;
};

/// Statistics over the sampled configurations, as `analyze` reports them.
struct Workspace {
  std::uint64_t count = 0;
  std::vector<CoordinateStatistics> coordinates;               ///< of all_signals
  std::vector<std::vector<DerivativeStatistics>> derivatives;  ///< [filter][coordinate]
  Eigen::MatrixXd mean_variance_parts;  ///< coordinates x encoders: mean variance due to each encoder
  /// Coordinates x encoders: mean variance of quantization alone, without the sources attributed to the
  /// encoder.
  Eigen::MatrixXd mean_quantization_parts;
  Eigen::MatrixXd mean_covariance;        ///< of all coordinates, mean over the configurations
  Eigen::MatrixXd covariance_at_largest;  ///< where the trace of the position's covariance is largest
  Eigen::VectorXd largest_at;             ///< that configuration [rad or m]
  /// [filter]: both covariances behind it, without entries where they are not known. Empty without sources
  /// and error along a motion: then they are ||H||_2^2 times the above.
  struct Filtered {
    Eigen::MatrixXd mean_covariance, covariance_at_largest;
  };
  std::vector<Filtered> filtered;
  Eigen::VectorXd largest_arms;  ///< [encoder]: largest |entry| in the position rows of J C [m/rad or 1]
  double smallest_cosine_of_pitch = 1;
  bool exact_percentiles = true;
};

/// The statistics of a figure; null: it is not known, or `sigma` is the same as `sigma_quantization`.
const Statistic* statistic_of(const Workspace&, const Figure&);

struct ConfigurationBatch;

struct WorkspaceOptions {
  unsigned threads = 0;  ///< 0: one per core; the result does not depend on it
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  /// Formats a batch as text; called on any thread.
  std::function<std::string(const ConfigurationBatch&)> text = {};
  /// Receives the texts in the order of the configurations.
  std::function<void(const std::string&)> write = {};
  /// Sees every batch of configurations once; called on any thread.
  std::function<void(const ConfigurationBatch&)> visit = {};
  /// [filter]: sigma of each encoder's error behind the filter in a motion, in quantization intervals
  /// (quantization_along_motion.hpp); empty: unknown.
  std::vector<Eigen::VectorXd> noise_in_motion = {};
  /// Compute worst case and sigma only: no rigorous bound, no shares of the encoders, no configuration of the
  /// largest position variance.
  bool brief = false;
  /// Whether `analyze` finds Analysis::warnings, which takes milliseconds a filter.
  bool warnings = true;
  InstructionSet instructions = instruction_set();
};

/// Statistics of all bounds over the configurations.
///
/// Memory is bounded beyond `exact_percentiles_limit` configurations. Blocks of configurations are summed and
/// joined in a fixed order, so that the result does not depend on the number of threads.
/// @param filters  norms of the derivative filters, one set of derivative statistics each
/// @throws Error (input; key `configurations`) when a joint angle exceeds 2^20 rad
Workspace workspace(const OperationalModel&, const std::vector<Norms>& filters, const Configurations&,
                    const WorkspaceOptions& = {});

/// Whether WorkspaceOptions::noise_in_motion has the noise behind a filter.
inline bool is_known(const std::vector<Eigen::VectorXd>& noise_in_motion, std::size_t filter) {
  return filter < noise_in_motion.size() && noise_in_motion[filter].size() > 0;
}

}  // namespace qerr
