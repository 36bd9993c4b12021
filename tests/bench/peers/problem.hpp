#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr::bench {

/// One robot and its configurations: the input of every contestant.
struct Problem {
  std::string name;
  OperationalModel model;         ///< coordinates x y z rx ry rz, encoders that round to nearest, no sources
  Configurations configurations;  ///< the same points, for contestants that sample themselves
  Eigen::MatrixXd points;         ///< independent joints x configurations [rad or m]
  /// Positions of all moving joints, mimics included: joints x configurations. For libraries that do not
  /// support mimics; equal to the points if there are none.
  Eigen::MatrixXd motions;
  Eigen::MatrixXd fold;     ///< joints x independent: a column of a mimic goes to its master's
  Eigen::MatrixXd weights;  ///< C diag(Delta): independent x encoders [rad or m]
};

/// The robot of a spec, or of a plain URDF from `base` (empty: the root) to `tip` (empty: the only leaf).
///
/// A spec provides the chain, the encoders' resolutions, the coupling and the ranges; its effects, filters,
/// coordinates and sampling method are ignored, so that all contestants have the same job: the six
/// coordinates at Sobol points. A URDF gets 2 pi/65536 and 10 um, and +-pi (+-1 m) where it has no limits.
/// @throws Error (input, file_system) as read_spec, read_urdf and make_chain do
Problem read_problem(const std::string& file, const std::string& base, const std::string& tip,
                     std::uint64_t count);

/// A calibrated robot: every fixed transform rotated by up to 1 mrad about and shifted by up to 0.1 mm along
/// each axis, from a fixed seed, so that no transform has a right angle or a zero.
Problem calibrated(Problem);

}  // namespace qerr::bench
