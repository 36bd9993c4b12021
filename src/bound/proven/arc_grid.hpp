#pragma once

#include <cstddef>
#include <vector>

namespace qerr {

/// Samples of a joint's angle, and nodes of the azimuth about its axis, for max over the range of a table.
///
/// Node j is at azimuth j `node_spacing`; the maximum at node j is over the samples first(j) .. first(j) +
/// intervals, at the angles node + lower + i `spacing`, ends of the range included. Neighbouring nodes share
/// samples where the lattices agree. A full turn has one node, as its maximum does not depend on the azimuth.
struct ArcGrid {
  bool full = false;
  std::size_t intervals = 0;  ///< between samples of one node; 0: the angle is fixed
  std::size_t nodes = 1;
  double spacing = 0, node_spacing = 0;  ///< [rad]
  std::vector<double> sample_cos, sample_sin, middle_cos,
      middle_sin;                          ///< of samples, and half way to the next
  std::vector<double> node_cos, node_sin;  ///< one more than nodes: the last is the first

  std::size_t first(std::size_t node) const { return node * step; }
  std::size_t step = 1;  ///< samples from one node's first to the next node's
};

/// @param target   largest spacing of samples and nodes [rad]
/// @param azimuths  nodes also for a full turn
ArcGrid arc_grid(double lower, double upper, double target, bool azimuths = false);

/// The grid of a joint that does not turn.
ArcGrid fixed_grid(double target);

}  // namespace qerr
