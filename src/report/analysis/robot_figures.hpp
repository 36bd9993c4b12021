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

/// The robot where the trace of the position's covariance is largest, and where it is the median of the
/// sample, with the ellipsoid of one sigma and the box of the worst case at the tip, in three views each.
std::string robot_figures(const Analysis&, const ConfigurationSample&);

}  // namespace qerr
