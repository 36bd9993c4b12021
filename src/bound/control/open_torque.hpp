#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "control/control.hpp"
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

}  // namespace qerr
