#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
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

/// Unit vectors at equal steps of the polar angle from z and at the azimuths of a joint's nodes. With one
/// azimuth (full turn) a function on it does not depend on the azimuth.
struct DirectionGrid {
  std::size_t rows = 0;  ///< polar angles, 0 to pi/2, or to pi
  bool half = true;      ///< even functions: half a sphere
  double polar_step = 0;
  const ArcGrid* azimuths = nullptr;         ///< outlives the grid
  std::vector<double> polar_cos, polar_sin;  ///< [row]

  std::size_t columns() const { return azimuths->nodes; }
  double polar(std::size_t row) const { return static_cast<double>(row) * polar_step; }
  /// Largest angle between two points of a cell.
  double diameter() const { return std::hypot(polar_step, azimuths->full ? 0 : azimuths->node_spacing); }
};

DirectionGrid direction_grid(bool half, double polar_step, const ArcGrid&);

/// The unit vector at a polar angle and an azimuth, and the tangent vectors along both: of a moment
/// perpendicular to u, the coordinates are those along `polar` and `azimuth`.
struct DirectionFrame {
  Eigen::Vector3d u, polar, azimuth;
};
DirectionFrame direction_frame(double polar_angle, double cosine, double sine);

/// Polar angle of a direction, and cosine and sine of its azimuth, which is 0 on the axis.
struct Angles {
  double polar, cosine, sine;
};
Angles angles_of(const Eigen::Vector3d&);

/// u = sum weight_j u_j with weights >= 0, over two or three nodes (or their opposites, for even functions),
/// and linear maps m_j of vectors m perpendicular to u with sum weight_j m_j = m, m_j perpendicular to u_j.
struct DirectionStencil {
  struct Vertex {
    std::size_t row = 0, column = 0;
    double weight = 0;
    Eigen::Matrix2d map = Eigen::Matrix2d::Zero();  ///< from the coordinates of m in the frame of u to those
                                                    ///< of m_j in that of u_j
    bool opposite = false;                          ///< the node is -u_j
  };
  std::array<Vertex, 3> vertices;
  std::size_t count = 0;
  double moment_residual = 0;     ///< largest |m - sum weight_j m_j| for |m| = 1
  double direction_residual = 0;  ///< |u - sum weight_j u_j|
};

/// @param target  frame of u; its tangent vectors are the coordinates of the maps
DirectionStencil direction_stencil(const DirectionGrid&, const DirectionFrame& target);

/// The weights alone; the maps and `moment_residual` are not set.
DirectionStencil direction_weights(const DirectionGrid&, const Eigen::Vector3d& u);

/// Upper bound of a sublinear function over all unit vectors, from its values at the nodes
/// ([row][column]).
double largest_over_directions(const DirectionGrid&, const std::vector<double>& values);

}  // namespace qerr
