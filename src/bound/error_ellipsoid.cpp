#include "bound/error_ellipsoid.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace qerr {

ErrorEllipsoid error_ellipsoid(const Eigen::Matrix3d& covariance) {
  // Scaled, since the iteration compares with absolute thresholds.
  const double scale = covariance.cwiseAbs().maxCoeff();
  if (!(scale > 0) || !std::isfinite(scale))
    return {Eigen::Vector3d::Constant(scale), Eigen::Matrix3d::Identity()};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / scale);
  ErrorEllipsoid e;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d direction = solver.eigenvectors().col(2 - i);  // eigenvalues ascend
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    e.directions.col(i) = direction[largest] < 0 ? (-direction).eval() : direction;
    e.semi_axes[i] = std::sqrt(scale * std::max(solver.eigenvalues()[2 - i], 0.0));
  }
  return e;
}

}  // namespace qerr
