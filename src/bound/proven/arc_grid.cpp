#include "bound/proven/arc_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

constexpr double turn = 2 * std::numbers::pi;

void set_nodes(ArcGrid& g) {
  for (std::size_t j = 0; j < g.nodes; ++j) {
    g.node_cos.push_back(std::cos(static_cast<double>(j) * g.node_spacing));
    g.node_sin.push_back(std::sin(static_cast<double>(j) * g.node_spacing));
  }
  g.node_cos.push_back(1);
  g.node_sin.push_back(0);
}

void set_samples(ArcGrid& g, double lower, std::size_t stride) {
  const std::size_t own = g.intervals + 1, count = g.full ? g.intervals : (g.nodes - 1) * g.step + own;
  for (std::size_t i = 0; i < count; ++i) {
    // Strides beyond the range leave gaps between the samples of neighbouring nodes.
    const std::size_t place = stride <= own ? i : i / own * stride + i % own;
    const double angle = lower + static_cast<double>(place) * (g.intervals > 0 ? g.spacing : g.node_spacing);
    g.sample_cos.push_back(std::cos(angle));
    g.sample_sin.push_back(std::sin(angle));
    g.middle_cos.push_back(std::cos(angle + g.spacing / 2));
    g.middle_sin.push_back(std::sin(angle + g.spacing / 2));
  }
}

}  // namespace

ArcGrid arc_grid(double lower, double upper, double target, bool azimuths) {
  ArcGrid g;
  const double width = std::min(upper - lower, turn);
  // A narrower range than 1e-9 of a turn is widened: a lattice of its own width would overflow the indices.
  constexpr double narrowest = 1e-9 * turn;
  if (!azimuths && width >= turn * (1 - 1e-12)) {
    g.full = true;
    g.intervals = static_cast<std::size_t>(std::ceil(turn / target));
    g.spacing = turn / static_cast<double>(g.intervals);
    set_nodes(g);
    set_samples(g, lower, 1);
    return g;
  }
  std::size_t stride = 1;
  if (width > 0) {
    const double covered = std::max(width, narrowest);
    g.intervals = static_cast<std::size_t>(std::ceil(covered / target));
    g.spacing = covered / static_cast<double>(g.intervals);
    stride = std::max<std::size_t>(1, static_cast<std::size_t>(target / g.spacing));
    g.node_spacing = static_cast<double>(stride) * g.spacing;
    g.nodes = static_cast<std::size_t>(std::ceil(turn / g.node_spacing));
  } else {
    g.nodes = static_cast<std::size_t>(std::ceil(turn / target));
    g.node_spacing = turn / static_cast<double>(g.nodes);
  }
  g.step = std::min(stride, g.intervals + 1);
  set_nodes(g);
  set_samples(g, lower, stride);
  return g;
}

ArcGrid fixed_grid(double target) { return arc_grid(0, 0, target); }

}  // namespace qerr
