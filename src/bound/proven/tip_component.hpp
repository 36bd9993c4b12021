#pragma once

#include <vector>

#include "bound/proven/chain_form.hpp"

namespace qerr {

enum class TipFigure { worst_case, sigma };

/// Upper bounds of a figure of the position along unit vectors that are fixed in the tip's frame, over the
/// box of the motions [m]; origins included, errors along a motion not. Rounding is included.
///
/// With u in the moved frame of joint k and l = p x u, p the tip there, the columns are linear in (u, l):
/// u . (z x (p - o)) = z . l - u . (z x o). Recursion from the base:
///   G_k(u, l) = L_k(u, l) + A_k(u, l), or the root of the sum of their squares for sigma,
///   A_k(u, l) = max over the motion q of F_k(Rz(q) u, Rz(q) l) (prismatic: of F_k(u, l + q z x u)),
///   F_k(u, l) = G_(k-1)(R_k u, R_k l + t_k x R_k u),
/// L_k the errors whose first joint is k; the answer is G_n(u, p x u). All are sublinear in (u, l) and even,
/// and tabulated and interpolated as in position_worst_case.hpp; errors that move distant joints have their
/// signs chosen, or are relaxed (position_sigma.hpp).
/// @param directions  in the tip's frame
/// @param cells       as in position_worst_case.hpp
std::vector<double> tip_component_bound(const ChainForm&, TipFigure,
                                        const std::vector<Eigen::Vector3d>& directions, double cells);

}  // namespace qerr
