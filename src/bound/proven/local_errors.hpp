#pragma once

#include <vector>

#include "bound/proven/chain_form.hpp"

namespace qerr {

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
