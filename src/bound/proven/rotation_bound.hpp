#pragma once

#include <vector>

#include "bound/proven/chain_form.hpp"

namespace qerr {

enum class RotationAxes { base, tip };

/// Upper bounds of figures of the rotation vector of the tip over the box of the motions [rad], without
/// errors along a motion; rounding included.
struct RotationBound {
  std::vector<double> along;  ///< of the components along given unit vectors of the base, or of the tip
  double length = 0;          ///< of the length
};

/// Worst case max |sum_g s_g h_g c_g + sum_g mean_g c_g|, c_g = sum_k a_gk u . z_k over the revolute joints.
///
/// The state of the recursion is u in the frame of a joint:
///   F_i(u) = L_i(u) + A_(i+1)(Q_i u),  A_i(u) = max over the motion q of F_i(Rz(q) u),
/// where L_i sums h |u . d| + mean u . d over the errors whose first joint is i (d = a z + a' z', both axes
/// fixed in its moved frame). Seen from the tip the joints are in the opposite order. F_i and A_i are
/// sublinear: tables over the sphere are interpolated from above, and between samples of q at the spacing s
/// the allowance is that of (1 - cos(s/2)) (horizontal part of u), a sum of horizontal samples with the total
/// weight (1 - cos(s/2))/cos(s/2). Errors that move joints further
/// apart: one recursion for each choice of their signs (position_worst_case.hpp).
/// @param cells  of the polar angle in a right angle; the relative error falls as 1/cells^2
RotationBound rotation_worst_case_bound(const ChainForm&, RotationAxes,
                                        const std::vector<Eigen::Vector3d>& directions, double cells);

/// The root of the variance of a component: the same with F_i^2 = sum variance (u . d)^2 + A_(i+1)^2, a
/// maximum of norms of linear functions of u. The length's does not depend on the configuration. Errors that
/// move joints further apart are relaxed to independent ones (position_sigma.hpp).
RotationBound rotation_sigma_bound(const ChainForm&, RotationAxes,
                                   const std::vector<Eigen::Vector3d>& directions, double cells);

}  // namespace qerr
