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
/// (position_sigma.hpp).
std::vector<FrameErrors> sigma_errors(const ChainForm&);

/// Largest distance of the tip from the origin of the frame before each motion, [k] of joint k counted
/// from 1.
std::vector<double> reaches_before_motion(const ChainForm&);

}  // namespace qerr
