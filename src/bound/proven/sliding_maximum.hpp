#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "bound/proven/kernels.hpp"

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

}  // namespace qerr
