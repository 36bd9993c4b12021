#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// A moving joint of a chain whose joints all move about or along z of their own frame:
/// x_(k-1) = translation + rotation Rz(motion) x_k, or translation + rotation (x_k + motion z).
struct ChainStep {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  bool prismatic = false;
  std::size_t coordinate = 0;   ///< independent joint that moves it
  double lower = 0, upper = 0;  ///< of the motion, multiplier and offset included [rad or m]
};

/// Errors that move the joints in one direction and are independent of all others.
struct DirectedError {
  Eigen::VectorXd of_joints;  ///< derivative of the chain's joints; the first that is not 0 is 1
  double half_width = 0, mean = 0, variance = 0;
  Eigen::Index first = 0, last = 0;  ///< joints that it moves: within [first, last]
};

/// An error of the position along a direction that is fixed in the moved frame of joint `link` - 1 (0: base).
struct DirectedOrigin {
  std::size_t link = 0;
  Eigen::Vector3d direction;
  double half_width = 0, mean = 0, variance = 0;
};

/// A model as the recursions along the chain need it.
struct ChainForm {
  std::vector<ChainStep> steps;  ///< base to tip
  Eigen::Isometry3d tip;         ///< in the moved frame of the last joint
  std::vector<DirectedError> errors;
  std::vector<DirectedOrigin> origins;

  std::size_t size() const { return steps.size(); }
  /// Upper bounds of the distance of the tip from the origin of each joint's moved frame; [0] is that of the
  /// base, [k] of joint k - 1.
  std::vector<double> reaches() const;
};

/// Choices of the signs of the errors that move joints further apart than neighbours, in their order: all, or
/// without means half of them, as a common sign of all errors does not change a magnitude.
std::vector<std::vector<double>> distant_signs(const ChainForm&);

/// The form of a model over a box of its joint ranges.
ChainForm chain_form(const OperationalModel&, const std::vector<Limits>& ranges);

/// What an error adds to the error along u, in the moved frame of its first joint with p the tip there:
/// width (D(u) . p + e . u), linear in u. Revolute columns: (u x z) . (p - o); prismatic ones: u . z.
struct LocalError {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();      ///< D(u) = u x axis, perpendicular to u
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();  ///< e
  double width = 1;                                    ///< half width or sigma
  double size = 0;    ///< largest |D(u) . p + e . u| over all configurations for |u| = 1
  double moment = 0;  ///< largest |D(u)|

  /// D(u) for |u| = 1, width included.
  Eigen::Vector3d moment_at(const Eigen::Vector3d& u) const { return width * u.cross(axis); }
  /// e . u, width included.
  double constant_at(const Eigen::Vector3d& u) const { return width * constant.dot(u); }
};

/// Errors of a moved frame.
struct FrameErrors {
  std::vector<LocalError> independent;
  LocalError fixed;  ///< means and errors of fixed sign; its width is 1
};

/// Half widths, with the signs of the errors that move distant joints.
/// @returns [k]: of joint k counted from 1
std::vector<FrameErrors> worst_case_errors(const ChainForm&, const std::vector<double>& distant_signs);

/// Sigmas, without means. Errors that move distant joints are relaxed to independent ones
/// (position_sigma_bound).
std::vector<FrameErrors> sigma_errors(const ChainForm&);

/// Largest distance of the tip from the origin of the frame before each motion, [k] of joint k counted
/// from 1.
std::vector<double> reaches_before_motion(const ChainForm&);

// Recursions along the chain, each with a state and tables of its own; chain_bound.hpp chooses among them.

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

/// Upper bounds of sigma of the position along unit vectors of the base, over the box of the motions [m];
/// origins included, errors along a motion not. Rounding is included.
///
/// The root of sum sigma_g^2 c_g^2 is the largest sum sigma_g b_g c_g over all b with |b| = 1. The recursion
/// is that of the worst case (position_worst_case_bound) with b_g in place of the signs, and what is left of
/// |b| beyond joint k, s, is a further number: F_k(u, m, s) is the largest, over beta^2 + s'^2 = s^2, of
///   V_k(u, m + beta sigma D(u), s') + beta sigma e . u,
/// one such step for each error; V_n = m . p. All are homogeneous of degree 1 and convex in (m, s) and
/// sublinear in (s u, m); at each direction u they are tabulated over the directions of (m, s)
/// (kernels.hpp). The circle of (beta, s') is replaced by a polygon around it.
/// @param cells  of the polar angle in a right angle; of m and of the circle in proportion
std::vector<double> component_sigma_bound(const ChainForm&, const std::vector<Eigen::Vector3d>& directions,
                                          double cells);

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
/// and tabulated and interpolated as in position_worst_case_bound; errors that move distant joints have their
/// signs chosen, or are relaxed (position_sigma_bound).
/// @param directions  in the tip's frame
/// @param cells       as in position_worst_case_bound
std::vector<double> tip_component_bound(const ChainForm&, TipFigure,
                                        const std::vector<Eigen::Vector3d>& directions, double cells);

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
/// apart: one recursion for each choice of their signs (position_worst_case_bound).
/// @param cells  of the polar angle in a right angle; the relative error falls as 1/cells^2
RotationBound rotation_worst_case_bound(const ChainForm&, RotationAxes,
                                        const std::vector<Eigen::Vector3d>& directions, double cells);

/// The root of the variance of a component: the same with F_i^2 = sum variance (u . d)^2 + A_(i+1)^2, a
/// maximum of norms of linear functions of u. The length's does not depend on the configuration. Errors that
/// move joints further apart are relaxed to independent ones (position_sigma_bound).
RotationBound rotation_sigma_bound(const ChainForm&, RotationAxes,
                                   const std::vector<Eigen::Vector3d>& directions, double cells);

/// Upper bound of a figure of the model over the box of the joint ranges: never exceeded, rounding included.
///
/// Dynamic programming along the chain: the five recursions above. The bound converges to the largest figure
/// as the grids are refined, also with errors that move two neighbours (differentials), and for the worst
/// case with errors that move any joints (the signs of at most 7 errors of distant joints are tried). For
/// sigma such distant errors are relaxed to independent ones unless there is no other error: the bound holds,
/// but a gap remains. Joints that mimic one another are independent within parts of their master's range, at
/// most 400 parts.
/// @param figure       worst_case or sigma of the position, of a coordinate or length
/// @param ranges       one per independent joint [rad or m]
/// @param known_lower  a value of the figure that is reached in the box
/// @param gap          the grid is refined until bound <= known_lower (1 + gap), or to a finest grid that
///   depends on `gap` only
/// @returns empty where the method does not apply (Euler angles, infinite ranges, more errors of distant
/// joints)
std::optional<double> chain_upper_bound(const OperationalModel&, const std::vector<Limits>& ranges,
                                        const Figure& figure, double known_lower, double gap);

}  // namespace qerr
