#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "qerr/bound/operational_error.hpp"

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

}  // namespace qerr
