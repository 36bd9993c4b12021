#pragma once

#include <optional>

#include "bound/proven/chain_form.hpp"

namespace qerr {

/// Upper bound, over the box of the motions, of the root of the summed variances of x y z of the tip [m],
/// without origins and errors along a motion; rounding included.
///
/// Backward recursion over the joints. Its state is v, the tip in the moved frame of joint k:
///   G_k(v)^2 = V_k(v) + M_k(v)^2,  M_k(v) = max over the motion of joint k of G_(k-1)(t_k + R_k Rz(q) v),
/// where V_k sums variance |a_k J_k + a_(k+1) J_(k+1)|^2 over the errors whose first joint is k. Axis k + 1
/// is fixed in the moved frame of joint k, so that both columns are functions of v. G_k is a maximum of norms
/// of affine maps of v, hence convex: the tables of M_k are interpolated from above, and the maximum over an
/// arc is that over the vertices of a polygon around it (its ends, and points at radius r/cos(spacing/2)).
///
/// An error that moves joints further apart is relaxed to independent ones: (sum_i x_i)^2 <= sum_i x_i^2 /
/// l_i with sum_i l_i = 1.
/// @param cells  nodes per reach; the relative error falls as 1/cells^2
double position_sigma_bound(const ChainForm&, double cells);

}  // namespace qerr
