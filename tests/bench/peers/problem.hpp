#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr::bench {

/// One robot and its configurations: what every contestant gets.
struct Problem {
  std::string name;
  OperationalModel model;         ///< coordinates x y z rx ry rz, encoders that round to nearest, no sources
  Configurations configurations;  ///< the same points for those who draw for themselves
  Eigen::MatrixXd points;         ///< independent joints x configurations [rad or m]
  /// What the chain's moving joints make of the points, mimics counted apart: joints x configurations.
  /// A gift to libraries that know no mimics; the points themselves where there are none.
  Eigen::MatrixXd motions;
  Eigen::MatrixXd fold;     ///< joints x independent: a column of a mimic goes to its master's
  Eigen::MatrixXd weights;  ///< C diag(Delta): independent x encoders [rad or m]
};

/// The robot of a spec, or of a plain URDF from `base` (empty: the root) to `tip` (empty: the only leaf).
///
/// Of a spec the chain, the encoders' resolutions, the coupling and the ranges are taken; its effects,
/// filters, coordinates and sampling method are left out, so that all contestants do one job: the six
/// coordinates at Sobol points. A URDF gets 2 pi/65536 and 10 um, and +-pi (+-1 m) where it has no limits.
/// @throws Error (input, file_system) as read_spec, read_urdf and make_chain do
Problem read_problem(const std::string& file, const std::string& base, const std::string& tip,
                     std::uint64_t count);

/// The robot as a calibration finds it: every fixed transform turned by up to 1 mrad and shifted by up to
/// 0.1 mm about and along each axis, from a fixed seed, so that no right angle and no zero is left.
Problem calibrated(Problem);

}  // namespace qerr::bench
