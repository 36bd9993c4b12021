#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/signal.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

/// Bounds of the tip's coordinates at one configuration, in the order of OperationalModel::coordinates [m or
/// rad].
struct OperationalError {
  Eigen::VectorXd mean;        ///< (J C) m and the sources' means; 0 when all encoders round to nearest
  Eigen::VectorXd half_width;  ///< 0.5 |J C| Delta and the sources' half widths
  Eigen::VectorXd
      worst_case;  ///< half_width + |mean| + peak along the motion: the linear bound (paper, Eq. 17)
  Eigen::VectorXd rigorous;  ///< with the second-order remainder; +inf for roll pitch yaw, which have none
  Eigen::VectorXd sigma;     ///< sqrt(diag Sigma_x), about the mean (paper, Eqs. 19 and 20)
  Eigen::MatrixXd
      weighted;  ///< (J C) diag(Delta), coordinates x encoders: Sigma_x = weighted weighted^T / 12
  double cosine_of_pitch = 1;  ///< 0 at the gimbal lock
  /// Coordinates x sources: sigma of each, with the sign of its column, and its |mean| + half width.
  Eigen::MatrixXd added_sigma, added_worst;
};

struct Control;  // src/control/control.hpp

/// The robot, its encoders and the coordinates of interest: everything that does not depend on the
/// configuration.
struct OperationalModel {
  Chain chain;
  Transmission transmission;
  std::vector<Coordinate> coordinates;
  std::vector<IndependentError> sources = {};  ///< errors other than quantization; empty: the ideal model
  /// What effects add along a motion; the same at every configuration.
  std::optional<ErrorAlongMotion> along_motion = {};
  CoordinateFrame frame = CoordinateFrame::base;
  /// xyz and rxyz, whose components are among the coordinates; only `workspace` has them.
  std::vector<Coordinate> lengths = {};
  /// Signals of other kinds, which only `workspace` has, too.
  std::vector<Signal> signals = {};
  /// The tips of `robot.tips` and each relative to each other, where the robot has several: `chain` is then
  /// that of the first, and there are no coordinates but the signals of tips. Null: one tip.
  std::shared_ptr<const std::vector<NamedTip>> tips = {};
  std::shared_ptr<const Control> control = {};  ///< the joints' controllers; null: none
};

/// The link of the tip, or those of several, `left_hand, right_hand`.
std::string tips_of(const OperationalModel&);

/// The coordinates, then the lengths, then the signals of other kinds: the order of a workspace's statistics.
std::vector<Signal> all_signals(const OperationalModel&);

/// All independent errors of the model: of its encoders, and its sources.
std::vector<IndependentError> independent_errors(const OperationalModel&);

/// Joint error of the model, with its sources and the error along its motion.
JointError joint_error(const OperationalModel&);

/// Error of the tip at independent coordinates q (paper, Eqs. 16 to 24, carried through the coupling).
///
/// Worst case 0.5 |J C| Delta + |mean|, covariance (J C) diag(Delta^2/12) (J C)^T.
///
/// The rigorous bound adds the second-order remainder of x = f(q) over the whole quantization box. With h_k
/// the largest error of moving joint k and S_k = sum_{i<=k, revolute} h_i (base to tip):
/// - position: rho = 1/2 sum_{k revolute} R_k h_k (2 S_{k-1} + h_k) + sum_{k prismatic} S_{k-1} h_k, since
///   d2p/dq_i dq_k = z_i x (z_k x (p - o_k)) for i <= k. R_k bounds the distance of the tip from axis k over
///   the box: R_k = |z_k x (p - o_k)| + sum_{m>k} h_m (R_m if revolute, 1 if prismatic), because only joints
///   beyond k change it.
/// - rotation vector of R_hat R^T: the angle never exceeds A = S_n; componentwise, for A <= pi, the linear
/// bound plus
///   1/2 sum_k h_k S_{k-1} (axes move) + A^2/4 + 0.034 A^3 (phi' = w - phi x w / 2 + c phi x (phi x w), c
///   |phi|^2 <= 0.1014 |phi|^2).
///
/// A source at a joint or an encoder enters like the quantization, by its column of J or J C: in the mean,
/// the half width, the box of the rigorous bound and, independent of all others, the variance. A displaced
/// origin shifts the tip by exactly R_k d, without remainder. The error along a motion adds its peak to the
/// bounds and its variance to sigma; its joints' peaks widen the box of the remainder.
/// @pre sigma: IPQN, the errors of the encoders are uniform and independent
OperationalError operational_error(const OperationalModel&, const Eigen::VectorXd& q);

/// Covariance Sigma_x of all coordinates, sources included, but not the error along a motion [m^2, m rad,
/// rad^2].
Eigen::MatrixXd covariance(const OperationalError&);

/// Covariance behind a filter: h2^2 times the encoders' part plus ratio^2 times the part of each source.
Eigen::MatrixXd covariance(const OperationalError&, double h2, const Eigen::VectorXd& ratios);

/// Bounds of one signal: its worst case and its standard deviation.
struct Bounds {
  double worst_case = 0;
  double sigma = 0;
};

/// Error of a filtered derivative, given the error of its input coordinate (paper, Eqs. 26 and 28).
///
/// |y| <= ||H||_1 half_width + |H(1)| |mean|, and for white x: sigma_y = ||H||_2 sigma_x.
/// @param half_width  of the operational coordinate's error about its mean [m or rad]
/// @param mean        of that error; 0 unless an encoder rounds down
/// @param sigma       of that error
/// @param norms       of the derivative filter [1/s for a velocity]
/// @returns bounds of the derivative [m/s or rad/s]
/// @pre steady state of the filter (the response to a mean that is switched on is a partial sum of h, not
/// H(1));
///   the Jacobian is constant over the filter's memory; sigma also needs white input, which is false below
///   about one count per sample
Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms);

/// Bounds of the filtered error for a coordinate of an OperationalError with error sources: their half widths
/// are multiplied by
/// ||H||_1 and their means by |H(1)| as well, the sigma of each by its own ratio, which depends on the
/// spectrum of the source.
/// @param ratios  of `sigma_ratios`, one per source; empty without sources
Bounds derivative_error(const OperationalError&, Eigen::Index coordinate, const Norms&,
                        const Eigen::VectorXd& ratios);

/// The ellipsoid of one sigma of three coordinates, { C^(1/2) u : |u| = 1 } for a covariance C.
struct ErrorEllipsoid {
  Eigen::Vector3d semi_axes;  ///< roots of C's eigenvalues, the largest first [m or rad]
  /// Columns: unit vectors along the semi-axes, in the axes of C. The largest component of each is positive;
  /// where two semi-axes are equal, the directions in their plane are arbitrary.
  Eigen::Matrix3d directions;
};

/// Sigma along a unit vector u is sqrt(u^T C u): at most the first semi-axis, at least the last one.
/// @param covariance  symmetric and not negative, but for rounding [m^2 or rad^2]
ErrorEllipsoid error_ellipsoid(const Eigen::Matrix3d& covariance);

/// Second-order remainders of the tip's pose over the whole quantization box (derivation:
/// `operational_error`), in terms that do not depend on the configuration.
///
/// Position: rho = position + sum_k per_column_k |linear part of column k of the joint Jacobian|.
struct LinearizationRemainder {
  double position = 0;         ///< [m]
  Eigen::VectorXd per_column;  ///< [moving joint]; 0 for prismatic ones
  double rotation = 0;        ///< of one component of the rotation vector; infinite for boxes beyond pi [rad]
  double rotation_angle = 0;  ///< bound of the rotation angle [rad]
};

/// @param largest  error of each independent joint [rad or m]
LinearizationRemainder linearization_remainder(const Chain&, const Eigen::VectorXd& largest);

}  // namespace qerr
