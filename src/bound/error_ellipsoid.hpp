#pragma once

#include <Eigen/Core>

namespace qerr {

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

}  // namespace qerr
