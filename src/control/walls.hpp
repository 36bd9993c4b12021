#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "control/control.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// The largest stiffness of a virtual wall, tau = -J^T n K n^T (x^ - x_wall), that gives off no energy at a
/// configuration. With g = J^T n:
///
/// - Against sampling and delay: the force is held and late, by T/2 + d T on average. Viscous damping b of
///   the joints takes up what that gives if K (T/2 + d T) g g^T <= diag(b), which is K <= 2/(T (1 + 2 d) sum
///   g_i^2/b_i). Of one joint, without delay: K <= 2 b/T.
/// - Against quantization: the error of the torque of joint i is at most K |g_i| sum_j |g^T C|_j Delta_j/2,
///   and gives off nothing while it is below the joint's Coulomb friction f_i: K <= 2 f_i/(|g_i| sum_j |g^T
///   C|_j Delta_j). Of one joint: K <= 2 f/Delta.
///
/// An error that lasts at rest beside that of counts, of play or unequal states, widens the counts; of
/// delays of several readings the longest is taken.
///
/// Of one axis both together are necessary and sufficient (Abbott and Okamura, IEEE Trans. Robotics 21(5),
/// 2005); of several joints, sufficient.
struct WallLimit {
  double sampling = 0, quantization = 0;  ///< [N/m]; infinite: the wall is felt by no joint
  std::size_t sampling_joint = 0;         ///< whose share g_i^2/b_i is largest
  std::size_t quantization_joint = 0;     ///< whose friction decides

  double stiffness() const { return std::min(sampling, quantization); }
  bool by_quantization() const { return quantization <= sampling; }
  std::size_t joint() const { return by_quantization() ? quantization_joint : sampling_joint; }
};

/// @param g         J^T n, of the independent joints [m/rad or 1]
/// @param coupling  joints by encoders
/// @param widths    of the encoders: twice the error that lasts at rest, a count of a perfect one
/// @pre damping and friction of all joints are stated
WallLimit wall_limit(const Control&, const Eigen::VectorXd& g, const Eigen::MatrixXd& coupling,
                     const Eigen::VectorXd& widths);

/// J^T n at a configuration. Entries below 1e-12 of the largest are rounding and become 0.
Eigen::VectorXd felt_by(const Chain&, const Wall&, const Eigen::VectorXd& q);

/// What must be stated for the walls: `damping of a1, friction of a1`; "" if nothing is missing.
std::string missing_for_walls(const Control&, const Chain&);

}  // namespace qerr
