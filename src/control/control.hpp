#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "encoder/loop_reading.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// A joint's controller u = kp (r - q) - kd H_v q, H_v a velocity filter, and what it moves:
/// M q'' + b q' = u, with Coulomb friction beside.
struct JointController {
  double kp = 0;                        ///< [N m/rad or N/m]
  double kd = 0;                        ///< [N m s/rad or N s/m]
  std::string velocity;                 ///< name of H_v among the filters; "": none, kd is 0
  Filter velocity_filter = {};          ///< H_v
  std::optional<double> inertia = {};   ///< M [kg m^2 or kg]; empty: of the URDF, at each configuration
  std::optional<double> damping = {};   ///< b [N m s/rad or N s/m]
  std::optional<double> friction = {};  ///< [N m or N]
  LoopReading reading = {};             ///< of the joint's own encoder

  bool acts() const { return kp != 0 || kd != 0; }
};

/// Sums of an impulse response h: h_0, those of |h_k| and h_k^2 over k > 0, and that of all h. The norms of k
/// + d H follow for any k and d, as k changes h_0 only.
struct ResponseSums {
  double first = 0, later_sum = 0, later_squares = 0, dc = 0;

  double l1(double k, double d) const;  ///< ||k + d H||_1
  double h2(double k, double d) const;  ///< ||k + d H||_2
};

ResponseSums response_sums(const Filter&);

/// An impedance at the tip, tau = J^T (K + D H_v) J (set point - q), K and D along x, y and z of the base.
struct TipImpedance {
  Eigen::Vector3d stiffness = Eigen::Vector3d::Zero();  ///< K [N/m]
  Eigen::Vector3d damping = Eigen::Vector3d::Zero();    ///< D [N s/m]
  std::string velocity;                                 ///< name of H_v; "": none, D is 0
  ResponseSums velocity_sums = {};
  double sample_rate = 0;  ///< of H_v [Hz]
};

/// A virtual wall: at the tip, a spring along `normal`, without damping.
struct Wall {
  std::string name;
  Eigen::Vector3d normal;  ///< unit vector in the base frame
};

struct StatedLoop;  // loop_response.hpp

/// The sections `control` and `walls` of a spec.
struct Control {
  double sample_rate = 0;               ///< of the loops [Hz]
  double delay = 0;                     ///< from reading to torque, beyond the hold [s]
  std::vector<JointController> joints;  ///< one for each independent joint
  std::optional<TipImpedance> tip;      ///< in place of the joints' gains
  std::vector<Wall> walls;
  /// The loop of each joint whose inertia is stated, evaluated when it is first asked for; equal loops are
  /// one. Set by `with_stated_loops`; else null.
  std::vector<std::shared_ptr<StatedLoop>> stated = {};

  /// The delay of a joint's loop in samples, with that of its reading; within 1e-9 of an integer it is that.
  double samples_of_delay(std::size_t joint) const;
};

/// Twice the error of each joint's reading that lasts at rest: a count of a perfect encoder [rad or m].
Eigen::VectorXd widths_at_rest(const Control&, const Eigen::VectorXd& resolutions);

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

/// A figure of a loop or of a wall that may be required.
struct ControlFigure {
  enum class Kind { gain_margin, phase_margin, bandwidth, limit_cycle, wall_stiffness, largest_kd };
  std::string name;  ///< `loop.a1.gain_margin`, `wall.table.stiffness`
  Kind kind = Kind::gain_margin;
  std::size_t index = 0;  ///< of the joint, or of the wall
  Dimension dimension = {};
};

/// All figures of the joints with a loop, of the walls, and of the gains.
std::vector<ControlFigure> control_figures(const Control&, const Chain&);

}  // namespace qerr
