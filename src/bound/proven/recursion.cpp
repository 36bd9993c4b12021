#include "bound/proven/recursion.hpp"

#include <numbers>

namespace qerr {

namespace {

constexpr double right_angle = std::numbers::pi / 2;

DirectionFrame frame_at(double c, double s, double cosine, double sine) {
  return {{s * cosine, s * sine, c}, {c * cosine, c * sine, -s}, {-sine, cosine, 0}};
}

DirectionFrame node_frame(const DirectionGrid& g, std::size_t row, std::size_t column) {
  return frame_at(g.polar_cos[row], g.polar_sin[row], g.azimuths->node_cos[column],
                  g.azimuths->node_sin[column]);
}

/// Weights of u in three unit vectors.
Eigen::Vector3d weights_of(const Eigen::Vector3d& u, const std::array<DirectionFrame, 3>& f) {
  const Eigen::Vector3d a = f[1].u.cross(f[2].u), b = f[2].u.cross(f[0].u), c = f[0].u.cross(f[1].u);
  return Eigen::Vector3d(a.dot(u), b.dot(u), c.dot(u)) / f[0].u.dot(a);
}

struct Choice {
  std::array<DirectionFrame, 3> frames;
  std::array<std::pair<std::size_t, std::size_t>, 3> nodes;
  Eigen::Vector3d weights = Eigen::Vector3d::Constant(-1);
};

/// Takes the triangle if u lies deeper in it.
void consider(const DirectionGrid& g, const Eigen::Vector3d& u,
              const std::array<std::pair<std::size_t, std::size_t>, 3>& nodes, Choice& best) {
  Choice c;
  c.nodes = nodes;
  for (std::size_t i = 0; i < 3; ++i) c.frames[i] = node_frame(g, nodes[i].first, nodes[i].second);
  if (std::abs(c.frames[0].u.cross(c.frames[1].u).dot(c.frames[2].u)) < 1e-14) return;
  c.weights = weights_of(u, c.frames);
  if (c.weights.minCoeff() > best.weights.minCoeff()) best = c;
}

/// The triangle that holds u: the sides of a cell along a parallel are great circles, so that it may belong
/// to the row above or below.
Choice triangle_of(const DirectionGrid& g, const Eigen::Vector3d& u) {
  const double polar = std::acos(std::clamp(u.z(), -1.0, 1.0));
  double azimuth = std::atan2(u.y(), u.x());
  if (azimuth < 0) azimuth += 2 * std::numbers::pi;
  const auto i = static_cast<std::ptrdiff_t>(polar / g.polar_step);
  const auto j = static_cast<std::ptrdiff_t>(azimuth / g.azimuths->node_spacing);
  const auto rows = static_cast<std::ptrdiff_t>(g.rows), columns = static_cast<std::ptrdiff_t>(g.columns());
  Choice best;
  const auto try_cell = [&](std::ptrdiff_t row, std::ptrdiff_t column) {
    if (row < 0 || row + 1 >= rows) return;
    const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>((column + columns) % columns);
    const auto next = static_cast<std::size_t>((column + 1 + columns) % columns);
    consider(g, u, {{{r, c}, {r + 1, c}, {r + 1, next}}}, best);
    consider(g, u, {{{r, c}, {r + 1, next}, {r, next}}}, best);
  };
  const std::ptrdiff_t column = std::min(j, columns - 1);
  for (const std::ptrdiff_t row : {i, i + 1, i - 1})
    if (best.weights.minCoeff() < -1e-13) try_cell(row, column);
  for (const std::ptrdiff_t row : {i, i + 1, i - 1})  // at a meridian: rounding of the azimuth
    for (const std::ptrdiff_t beside : {column - 1, column + 1})
      if (best.weights.minCoeff() < -1e-13) try_cell(row, beside);
  return best;
}

/// The maps m_j = P_j x, P_j = I - u_j u_j^T, where x is perpendicular to u and sum weight_j P_j x = m in the
/// tangent plane of u; what is left is along u and of third order in the cell.
void set_maps(DirectionStencil& s, const DirectionFrame& target,
              const std::array<DirectionFrame, 3>& frames) {
  Eigen::Matrix<double, 3, 2> basis;
  basis << target.polar, target.azimuth;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < s.count; ++i) {
    const Eigen::Vector3d& u = frames[i].u;
    sum += s.vertices[i].weight * (basis.transpose() * (basis - u * (u.transpose() * basis)));
  }
  const Eigen::Matrix<double, 3, 2> x = basis * sum.inverse();
  Eigen::Matrix<double, 3, 2> left = basis;
  for (std::size_t i = 0; i < s.count; ++i) {
    const DirectionFrame& f = frames[i];
    s.vertices[i].map.row(0) = f.polar.transpose() * x;
    s.vertices[i].map.row(1) = f.azimuth.transpose() * x;
    left -=
        s.vertices[i].weight * (f.polar * s.vertices[i].map.row(0) + f.azimuth * s.vertices[i].map.row(1));
  }
  s.moment_residual = left.norm();
}

/// Along the meridian of u, whose nodes are as good as any others for a function without azimuth.
std::array<DirectionFrame, 3> on_meridian(const DirectionGrid& g, const Eigen::Vector3d& u,
                                          DirectionStencil& s) {
  const auto [polar, cosine, sine] = angles_of(u);
  const std::size_t row = std::min(static_cast<std::size_t>(polar / g.polar_step), g.rows - 2);
  std::array<DirectionFrame, 3> frames;
  s.count = 2;
  for (std::size_t i = 0; i < 2; ++i) {
    s.vertices[i].row = row + i;
    frames[i] = frame_at(g.polar_cos[row + i], g.polar_sin[row + i], cosine, sine);
  }
  const double part = std::clamp(polar - g.polar(row), 0.0, g.polar_step);
  s.vertices[0].weight = std::sin(g.polar_step - part) / std::sin(g.polar_step);
  s.vertices[1].weight = std::sin(part) / std::sin(g.polar_step);
  return frames;
}

std::array<DirectionFrame, 3> on_triangle(const DirectionGrid& g, const Eigen::Vector3d& u,
                                          DirectionStencil& s) {
  const Choice c = triangle_of(g, u);
  s.count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    s.vertices[i].row = c.nodes[i].first;
    s.vertices[i].column = c.nodes[i].second;
    s.vertices[i].weight = std::max(0.0, c.weights[i]);
  }
  return c.frames;
}

/// The stencil without maps, and the frames of its nodes.
DirectionStencil weights_at(const DirectionGrid& g, Eigen::Vector3d u,
                            std::array<DirectionFrame, 3>& frames) {
  const bool opposite = g.half && u.z() < 0;
  if (opposite) u = -u;
  DirectionStencil s;
  frames = g.azimuths->full ? on_meridian(g, u, s) : on_triangle(g, u, s);
  for (std::size_t i = 0; i < s.count; ++i) {
    s.vertices[i].opposite = opposite;
    u -= s.vertices[i].weight * frames[i].u;
  }
  s.direction_residual = u.norm();
  return s;
}

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

DirectionGrid direction_grid(bool half, double polar_step, const ArcGrid& azimuths) {
  const double range = half ? right_angle : 2 * right_angle;
  const auto cells = static_cast<std::size_t>(std::ceil(range / polar_step - 1e-9));
  DirectionGrid g{cells + 1, half, range / static_cast<double>(cells), &azimuths, {}, {}};
  for (std::size_t row = 0; row < g.rows; ++row) {
    g.polar_cos.push_back(std::cos(g.polar(row)));
    g.polar_sin.push_back(std::sin(g.polar(row)));
  }
  return g;
}

DirectionFrame direction_frame(double polar_angle, double cosine, double sine) {
  return frame_at(std::cos(polar_angle), std::sin(polar_angle), cosine, sine);
}

Angles angles_of(const Eigen::Vector3d& u) {
  const double across = u.head<2>().norm();
  return {std::atan2(across, u.z()), across > 0 ? u.x() / across : 1, across > 0 ? u.y() / across : 0};
}

DirectionStencil direction_stencil(const DirectionGrid& g, const DirectionFrame& target) {
  std::array<DirectionFrame, 3> frames;
  DirectionStencil s = weights_at(g, target.u, frames);
  set_maps(s, target, frames);
  return s;
}

DirectionStencil direction_weights(const DirectionGrid& g, const Eigen::Vector3d& u) {
  std::array<DirectionFrame, 3> frames;
  return weights_at(g, u, frames);
}

double largest_over_directions(const DirectionGrid& g, const std::vector<double>& values) {
  double largest = 0;
  const std::size_t columns = g.columns();
  if (g.azimuths->full) {
    for (std::size_t i = 0; i + 1 < g.rows; ++i)
      largest = std::max(largest, std::max(values[i], values[i + 1]) / std::cos(g.polar_step / 2));
    return largest;
  }
  // A point of the plane triangle of three unit vectors is no nearer to 0 than the plane: sum weight_j <=
  // 1/distance.
  const auto add = [&](const std::array<std::pair<std::size_t, std::size_t>, 3>& nodes) {
    std::array<Eigen::Vector3d, 3> u;
    double value = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      u[i] = node_frame(g, nodes[i].first, nodes[i].second).u;
      value = std::max(value, values[nodes[i].first * columns + nodes[i].second]);
    }
    const Eigen::Vector3d normal = (u[1] - u[0]).cross(u[2] - u[0]);
    if (normal.norm() < 1e-14) return;
    largest = std::max(largest, value * normal.norm() / std::abs(normal.dot(u[0])));
  };
  for (std::size_t i = 0; i + 1 < g.rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t next = (j + 1) % columns;
      add({{{i, j}, {i + 1, j}, {i + 1, next}}});
      add({{{i, j}, {i + 1, next}, {i, next}}});
    }
  return largest;
}

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
