#pragma once

#include <optional>
#include <vector>

#include "bound/proven/chain_form.hpp"

namespace qerr {

/// Upper bounds of the worst case of positions over the box of the motions, linear kinematics [m].
struct PositionWorstCase {
  std::vector<double> along;  ///< of the components along given unit vectors of the base, origins included
  double length = 0;          ///< of the length, without origins
};

/// Upper bounds of max |sum of all errors along u|; errors along a motion are not included. Rounding is.
///
/// Recursion from the tip. The error along u of the base is a sum of s_g h_g c_g over the errors g, s_g =
/// +-1, c_g = sum_k a_gk (u x z_k) . (p - o_k) (prismatic: u . z_k), so that what the joints up to k add is m
/// . p + constant, m perpendicular to u, p the tip. With u and m in the frame of a joint,
///   F_k(u, m) = max over signs of V_k(u, m + sum_g s_g h_g D_g(u)) + sum_g s_g h_g e_g . u,
///   A_k(u, m) = max over the motion q of F_k(Rz(-q) u, Rz(-q) m),  V_n = m . p,
///   V_(k-1)(u, m) = m . t_k + A_k(R_k^T u, R_k^T m);
/// the answer is V_0(u, 0). An error belongs to its first joint k; axis k + 1 is fixed in the moved frame of
/// joint k, so that an error of two neighbours is one step. Errors that move joints further apart are part of
/// the recursion with one sign each, and the largest over all their signs is taken. Means have the sign of u.
///
/// All these functions are maxima of linear functions of (u, m): sublinear. They are even in u unless some
/// sign is fixed. A_k is tabulated over half a sphere (or all of it) and the plane of m, and interpolated by
/// (u, m) = sum_j L_j (u_j, m_j), A_k(u, m) <= sum_j L_j A_k(u_j, m_j) + residuals. Between samples of q at
/// the spacing d, (u, m)(q) = average of two samples + (1 - cos(d/2)) (horizontal parts), whose values are
/// bounded by |m| reach and |u| (sum of errors).
/// @param cells  of the polar angle in a right angle, and per radius of the disc of m
PositionWorstCase position_worst_case_bound(const ChainForm&, const std::vector<Eigen::Vector3d>& directions,
                                            double cells);

}  // namespace qerr
