#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "bound/proven/direction_grid.hpp"
#include "bound/proven/kernels.hpp"
#include "core/parallel.hpp"

namespace qerr {

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
  std::size_t size() const { return static_cast<std::size_t>(nodes * nodes); }
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
