#include "bound/largest_corner.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace qerr {

namespace {

constexpr Eigen::Index most_tried = 12;

double square_from(const Eigen::Vector3d& mean, const Eigen::Vector3d& corner) {
  return corner.squaredNorm() + mean.squaredNorm() + 2 * std::abs(mean.dot(corner));  // of both +-corner
}

double largest_of_all(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  const Eigen::Index n = generators.cols();
  Eigen::Vector3d corner = generators.rowwise().sum();
  double largest = square_from(mean, corner);
  std::uint64_t signs = 0;
  for (std::uint64_t k = 1; k < (std::uint64_t{1} << (n - 1)); ++k) {
    const auto flipped = static_cast<Eigen::Index>(__builtin_ctzll(k));  // Gray code: one sign a step
    signs ^= std::uint64_t{1} << flipped;
    corner += (signs >> flipped & 1 ? -2 : 2) * generators.col(flipped);
    largest = std::max(largest, square_from(mean, corner));
  }
  return largest;
}

/// The largest over the vertices at the ends of the edges along g_i of the face whose normal is `normal`.
double largest_at_edge(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators, Eigen::Index i,
                       const Eigen::Vector3d& normal) {
  constexpr double in_face = 1e-12;
  const Eigen::Vector3d along = generators.col(i), across = normal.cross(along);
  double largest = 0;
  for (const double side : {-1, 1})
    for (const double end : {-1, 1}) {
      Eigen::Vector3d corner = Eigen::Vector3d::Zero();
      for (Eigen::Index k = 0; k < generators.cols(); ++k) {
        const Eigen::Vector3d g = generators.col(k);
        const double off = normal.dot(g), aside = side * across.dot(g);
        const double sign = std::abs(off) > in_face * normal.norm() * g.norm()     ? off
                            : std::abs(aside) > in_face * across.norm() * g.norm() ? aside
                                                                                   : end * along.dot(g);
        corner += sign < 0 ? Eigen::Vector3d(-g) : g;
      }
      largest = std::max(largest, square_from(mean, corner));
    }
  return largest;
}

double largest_vertex(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  double largest = 0;
  Eigen::Index longest = 0;
  generators.colwise().squaredNorm().maxCoeff(&longest);
  bool parallel = true;
  for (Eigen::Index i = 0; i < generators.cols(); ++i)
    for (Eigen::Index j = 0; j < generators.cols(); ++j) {
      const Eigen::Vector3d a = generators.col(i), b = generators.col(j), normal = a.cross(b);
      if (!(normal.norm() > 1e-12 * a.norm() * b.norm())) continue;
      parallel = false;
      largest = std::max(largest, largest_at_edge(mean, generators, i, normal));
    }
  if (!parallel) return largest;
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  for (const auto& g : generators.colwise())
    corner += g.dot(generators.col(longest)) < 0 ? Eigen::Vector3d(-g) : Eigen::Vector3d(g);
  return square_from(mean, corner);
}

}  // namespace

double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  if (generators.cols() == 0) return mean.norm();
  return std::sqrt(generators.cols() <= most_tried ? largest_of_all(mean, generators)
                                                   : largest_vertex(mean, generators));
}

}  // namespace qerr
