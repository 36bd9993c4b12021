#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "encoder/loop_reading.hpp"
#include "qerr/filter/filter.hpp"

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

}  // namespace qerr
