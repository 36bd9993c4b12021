#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "bound/proven/kernels.hpp"
#include "core/parallel.hpp"

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

/// Replaces row i of `rows` by the maximum of rows i .. i + window - 1, elementwise, for i <= count - window
/// (van Herk: maxima from the starts and to the ends of blocks).
/// @param values  [count][width]; rows beyond count - window are left undefined
/// @param memory  [count][width]
/// @pre 1 <= window <= count
template <class Number>
void sliding_maximum(Number* values, std::size_t count, std::size_t window, std::size_t width,
                     Number* memory) {
  for (std::size_t i = 0; i < count; ++i) {
    const Number* from = values + i * width;
    Number* to = memory + i * width;
    if (i % window == 0)
      std::copy(from, from + width, to);
    else
      for (std::size_t c = 0; c < width; ++c) to[c] = std::max(memory[(i - 1) * width + c], from[c]);
  }
  for (std::size_t i = count - 1; i-- > 0;) {
    if ((i + 1) % window == 0) continue;
    for (std::size_t c = 0; c < width; ++c)
      values[i * width + c] = std::max(values[i * width + c], values[(i + 1) * width + c]);
  }
  for (std::size_t i = 0; i + window <= count; ++i)
    for (std::size_t c = 0; c < width; ++c)
      values[i * width + c] = std::max(values[i * width + c], memory[(i + window - 1) * width + c]);
}

/// Square grid over the vectors m perpendicular to a direction with |m| <= radius, in coordinates along its
/// tangent vectors. Only nodes of cells that meet the disc are filled.
struct MomentDisc {
  double radius = 0, step = 0;
  int nodes = 3;
  std::vector<int> begin, end;

  double at(int node) const { return (node - 0.5 * (nodes - 1)) * step; }
  /// Largest |m| of the nodes of cells that meet the disc.
  double reach() const { return radius + std::sqrt(2.0) * step; }
  std::size_t size() const { return nodes * nodes; }
  SliceNodes view() const { return {nodes, begin.data(), end.data()}; }
};

/// @param nodes  per side; odd, so that m = 0 is a node
inline MomentDisc moment_disc(double radius, int nodes) {
  MomentDisc d;
  d.nodes = nodes;
  d.radius = radius;
  // Positions in floats: 1e-4 of a cell beyond the disc.
  d.step = 2 * radius / (nodes - 1 - 2e-4);
  for (int a = 0; a < nodes; ++a) {
    d.begin.push_back(nodes);
    d.end.push_back(0);
    for (int b = 0; b < nodes; ++b)
      if (std::hypot(d.at(a), d.at(b)) <= d.reach() * (1 + 1e-6)) {
        if (d.begin.back() > b) d.begin.back() = b;
        d.end.back() = b + 1;
      }
  }
  return d;
}

/// A function of a direction before the motion of a joint, u, and of what a slice holds beside it (one
/// number: nothing): the largest, over the motion, of a function of the moved frame.
template <class Number>
struct DirectionTable {
  ArcGrid arc;
  DirectionGrid directions;
  std::vector<Number> table;  ///< [row][column][slice]

  /// Where the slice of a node begins.
  std::size_t place(const DirectionStencil::Vertex& v, std::size_t slice) const {
    return (v.row * directions.columns() + v.column) * slice;
  }
  /// `value`, and the weighted sum over the nodes of a stencil of the numbers at a place of their slices.
  double added(double value, const DirectionStencil& s, std::size_t slice, std::size_t at) const {
    for (std::size_t i = 0; i < s.count; ++i)
      value += s.vertices[i].weight * table[place(s.vertices[i], slice) + at];
    return value;
  }
};

/// Fills the table, row by row in parallel.
/// @param slice   numbers of a slice
/// @param fill    (frame, values): raises a slice, which begins at the lowest numbers, to the function at a
/// sample of the motion
/// @param finish  (row, column, values): completes a slice of the maximum over the motion
template <class Number, class Fill, class Finish>
void tabulate(DirectionTable<Number>& t, std::size_t slice, const Fill& fill, const Finish& finish) {
  const std::size_t columns = t.directions.columns(), samples = t.arc.sample_cos.size();
  t.table.assign(t.directions.rows * columns * slice, 0);
  parallel_for(t.directions.rows, 0, [&](std::size_t row) {
    std::vector<Number> values(samples * slice, -std::numeric_limits<Number>::max()), memory;
    for (std::size_t i = 0; i < samples; ++i)
      fill(direction_frame(t.directions.polar(row), t.arc.sample_cos[i], t.arc.sample_sin[i]),
           values.data() + i * slice);
    if (t.arc.full) {
      for (std::size_t i = 1; i < samples; ++i)
        for (std::size_t c = 0; c < slice; ++c) values[c] = std::max(values[c], values[i * slice + c]);
    } else if (t.arc.intervals > 0) {
      memory.resize(values.size());
      sliding_maximum(values.data(), samples, t.arc.intervals + 1, slice, memory.data());
    }
    Number* const to = t.table.data() + row * columns * slice;
    for (std::size_t j = 0; j < columns; ++j) {
      std::copy_n(values.data() + (t.arc.full ? 0 : t.arc.first(j)) * slice, slice, to + j * slice);
      finish(row, j, to + j * slice);
    }
  });
}

}  // namespace qerr
