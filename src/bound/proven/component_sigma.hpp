#pragma once

#include <vector>

#include "bound/proven/chain_form.hpp"

namespace qerr {

/// Upper bounds of sigma of the position along unit vectors of the base, over the box of the motions [m];
/// origins included, errors along a motion not. Rounding is included.
///
/// The root of sum sigma_g^2 c_g^2 is the largest sum sigma_g b_g c_g over all b with |b| = 1. The recursion
/// is that of the worst case (position_worst_case.hpp) with b_g in place of the signs, and what is left of
/// |b| beyond joint k, s, is a further number: F_k(u, m, s) is the largest, over beta^2 + s'^2 = s^2, of
///   V_k(u, m + beta sigma D(u), s') + beta sigma e . u,
/// one such step for each error; V_n = m . p. All are homogeneous of degree 1 and convex in (m, s) and
/// sublinear in (s u, m); at each direction u they are tabulated over the directions of (m, s)
/// (cone_kernels.hpp). The circle of (beta, s') is replaced by a polygon around it.
/// @param cells  of the polar angle in a right angle; of m and of the circle in proportion
std::vector<double> component_sigma_bound(const ChainForm&, const std::vector<Eigen::Vector3d>& directions,
                                          double cells);

}  // namespace qerr
