#pragma once

#include <Eigen/Core>

namespace qerr {

/// The largest length of a vector m + sum s_i g_i over all signs s_i = +-1: the farthest corner of a box that
/// is mapped linearly to space.
///
/// The farthest point of a zonotope is a vertex. Up to 12 generators all signs are tried. Beyond, the
/// vertices are enumerated: each lies at an edge along some g_i of a face with the normal d = g_i x g_j,
/// where the sign of g_k is that of its component along d; in the face, along d x g_i; along the edge, along
/// g_i. That is O(n^3) for n generators.
/// @param generators  3 x n
double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators);

}  // namespace qerr
