#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "control/control.hpp"
#include "control/loop.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// What the errors make of a joint's torque, the loop open.
struct OpenTorque {
  std::size_t joint = 0;
  double worst_case = 0;           ///< largest over the configurations [N m or N]
  std::optional<double> relative;  ///< to the URDF's effort limit
  Eigen::VectorXd share;           ///< [encoder]: part of the worst case, averaged over the configurations
};

/// The torques of all joints with a controller due to errors within their half widths; means are left out.
/// @param configurations  joints x configurations
std::vector<OpenTorque> open_torques(const OperationalModel&, const Eigen::MatrixXd& configurations);

/// The largest kd at which the worst case or sigma of a joint's torque keeps a limit, kp as stated; 0 if none
/// does.
double largest_kd(const OperationalModel&, std::size_t joint, Bound, double limit);

/// A joint's loop over the configurations: the least margins and bandwidth, the largest limit cycle.
struct WorstLoop {
  std::size_t joint = 0;
  double least_inertia = 0, largest_inertia = 0;  ///< [kg m^2 or kg]
  bool stable = false;                            ///< at all inertias
  double unstable_inertia = 0;                    ///< of an unstable loop: one at which it is
  LoopMargins margins;                            ///< least; of an unstable loop at that inertia
  LimitCycle cycle;                               ///< largest; of a stable loop
};

/// The loops of some joints, each at the worst of its inertias at the configurations: the l1 norms are
/// certified where they are largest. Joints with one loop share its evaluation.
/// @param joints  whose inertia is known
/// @param configurations  joints x configurations
std::vector<WorstLoop> worst_loops(const OperationalModel&, const std::vector<std::size_t>& joints,
                                   const Eigen::MatrixXd& configurations);

/// A wall: the least limit over the configurations, and where it is.
struct WorstWall {
  std::string name;
  WallLimit limit;
  double sampling = 0, quantization = 0;  ///< the least of either condition [N/m]
  Eigen::VectorXd at;
};

/// @param configurations  joints x configurations
/// @pre damping and friction of all joints are stated
WorstWall worst_wall(const OperationalModel&, const Wall&, const Eigen::MatrixXd& configurations);

}  // namespace qerr
