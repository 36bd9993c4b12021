#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "qerr/report/analysis.hpp"

namespace qerr {

/// Figures at single configurations of an analysis, for pictures: of all, or of so many that a picture does
/// not show the difference.
struct ConfigurationSample {
  std::uint64_t of = 0;                    ///< configurations of the analysis
  std::vector<Eigen::VectorXd> q;          ///< [rad or m]
  std::vector<Eigen::Vector3d> tips;       ///< in the base frame [m]
  std::vector<std::vector<double>> worst;  ///< [coordinate or length][configuration]: worst case
  std::vector<double> trace;               ///< [configuration]: variance of the position
  /// [figure]: values of `for_each_figure` in its order; sorted.
  std::vector<std::vector<double>> distributions;

  bool complete() const { return q.size() == of; }
};

/// At most so many: the standard error of a percentage is then below 0.3 %, half a pixel.
inline constexpr std::uint64_t most_sampled = std::uint64_t{1} << 15;

/// Configurations to draw, equal for any number of threads: the first ones of Sobol's sequence and of random
/// points, which are spread like all of them; of a grid and of a list one at random of each of equally many
/// parts.
ConfigurationSample configuration_sample(const Analysis&);

/// "" of a complete sample, else how many of the configurations it has.
std::string sampled_note(const ConfigurationSample&);

/// Pictures of the page of `analyze`, as markup.

/// Each encoder's share: of the tip's position (`encoder_budget`), and of the variance and of the worst case
/// of each coordinate, one to be chosen.
std::string budget_figures(const Analysis&);

/// The largest worst case of each coordinate by the position of the tip, one coordinate to be chosen.
std::string workspace_figures(const Analysis&, const ConfigurationSample&);

/// The distribution of every bound, one quantity to be chosen, with limits required of them and proven
/// maxima.
std::string distribution_figures(const Analysis&, const ConfigurationSample&);

/// The robot where the trace of the position's covariance is largest, and where it is the median of the
/// sample, with the ellipsoid of one sigma and the box of the worst case at the tip, in three views each.
std::string robot_figures(const Analysis&, const ConfigurationSample&);

}  // namespace qerr
