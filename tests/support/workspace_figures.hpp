#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "qerr/bound/workspace.hpp"

/// The figures of a workspace as a list, to compare those of two robots.
namespace qerr::testing {

/// A figure and the size to which its rounding error is relative.
struct WorkspaceFigure {
  double value = 0, size = 0;
  bool metres = false;  ///< proportional to the lengths of the robot; false: to its angles
};

/// The largest distance between the base and the tip [m].
inline double largest_extent(const Chain& chain, const std::vector<Limits>& ranges) {
  double extent = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) {
    const Limits& range = ranges[joint.coordinate];
    extent += joint.origin.translation().norm();
    if (joint.prismatic)
      extent += std::abs(joint.multiplier) * std::max(std::abs(range.lower), std::abs(range.upper)) +
                std::abs(joint.offset);
  }
  return extent;
}

/// What the errors of joints and sources could add up to: every joint with the largest lever arm [m or rad].
/// An entry of the Jacobian is a difference of positions, rounded relative to that arm and not to its value.
inline double largest_sum(const OperationalModel& m, const std::vector<Limits>& ranges, bool metres) {
  const JointError e = joint_error(m);
  const Eigen::VectorXd joints = e.worst_case + e.sigma;
  double angles = 0, shifts = 0;
  for (const ChainJoint& joint : m.chain.joints)
    (joint.prismatic ? shifts : angles) +=
        std::abs(joint.multiplier) * joints[static_cast<Eigen::Index>(joint.coordinate)];
  for (const IndependentError& s : m.sources)
    if (s.where == IndependentError::Where::origin) shifts += std::abs(s.mean) + s.half_width + s.sigma;
  // The linearization remainder adds half the square of the angles.
  return metres ? largest_extent(m.chain, ranges) * angles * (1 + angles) + shifts * (1 + angles)
                : angles * (1 + angles);
}

/// The largest factor by which a filter multiplies an error.
inline double largest_ratio(const OperationalModel& m, const Norms& filter, std::size_t index) {
  double ratio = filter.l1.upper;
  for (const IndependentError& s : m.sources)
    if (index < s.sigma_ratios.size()) ratio = std::max(ratio, s.sigma_ratios[index]);
  return ratio;
}

/// Every statistic of the worst case, the rigorous one, where there is one, and sigma, also behind filters.
/// @param ranges  of the independent joints
/// @param first   index of the first coordinate of the list, in all_signals
inline std::vector<WorkspaceFigure> workspace_figures(const OperationalModel& m,
                                                      const std::vector<Norms>& filters,
                                                      const std::vector<Limits>& ranges, const Workspace& w,
                                                      std::size_t first = 0) {
  const std::vector<Signal> coordinates = all_signals(m);
  std::vector<WorkspaceFigure> list;
  for (std::size_t c = first; c < coordinates.size(); ++c) {
    const bool metres = coordinates[c].unit == "m";
    const double size = largest_sum(m, ranges, metres);
    const auto append = [&](const Statistic& s, double factor) {
      for (const StatisticKind& kind : statistic_kinds())
        list.push_back({s.*kind.value, factor * size, metres});
    };
    append(w.coordinates[c].worst_case, 1);
    append(w.coordinates[c].sigma, 1);
    if (std::isfinite(w.coordinates[c].worst_case_rigorous.max))
      append(w.coordinates[c].worst_case_rigorous, 1);
    for (std::size_t f = 0; f < filters.size(); ++f) {
      const double ratio = largest_ratio(m, filters[f], f);
      append(w.derivatives[f][c].worst_case, ratio);
      if (w.derivatives[f][c].sigma) append(*w.derivatives[f][c].sigma, ratio);
    }
  }
  return list;
}

/// Every figure of the second list is `metre` or `radian` times that of the first, to `tolerance` of
/// their size.
inline bool figures_scale(const std::vector<WorkspaceFigure>& a, const std::vector<WorkspaceFigure>& b,
                          double metre, double radian, double tolerance) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [&](const WorkspaceFigure& x, const WorkspaceFigure& y) {
        const double factor = x.metres ? metre : radian;
        return x.metres == y.metres &&
               std::abs(factor * x.value - y.value) <= tolerance * std::max(factor * x.size, y.size);
      });
}

inline bool same_figures(const std::vector<WorkspaceFigure>& a, const std::vector<WorkspaceFigure>& b,
                         double tolerance) {
  return figures_scale(a, b, 1, 1, tolerance);
}

}  // namespace qerr::testing
