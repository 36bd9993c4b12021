#include "tip_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::atan2(-r(2, 0), cosine_of_pitch(r)),
          std::atan2(r(1, 0), r(0, 0))};
}

/// Of a small rotation too: the axis comes from the antisymmetric part, which does not cancel.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& r) {
  const Eigen::Vector3d twice_sine{r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};
  const double sine = 0.5 * twice_sine.norm(), angle = std::atan2(sine, 0.5 * (r.trace() - 1));
  return sine < 1e-300 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(twice_sine * (0.5 * angle / sine));
}

}  // namespace

Eigen::VectorXd tip_error(const std::vector<Coordinate>& coordinates, const Eigen::Isometry3d& estimate,
                          const Eigen::Isometry3d& truth) {
  const auto any = [&](auto property) {
    return std::any_of(coordinates.begin(), coordinates.end(), property);
  };
  Eigen::Matrix<double, 9, 1> all = Eigen::Matrix<double, 9, 1>::Zero();
  all.head<3>() = estimate.translation() - truth.translation();
  if (any(is_rotation_vector))
    all.segment<3>(3) = rotation_vector(estimate.linear() * truth.linear().transpose());
  if (any(is_euler_angle)) {
    const Eigen::Vector3d difference = roll_pitch_yaw(estimate.linear()) - roll_pitch_yaw(truth.linear());
    for (Eigen::Index i = 0; i < 3; ++i) all[6 + i] = std::remainder(difference[i], 2 * std::numbers::pi);
  }
  Eigen::VectorXd error(static_cast<Eigen::Index>(coordinates.size()));
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    error[static_cast<Eigen::Index>(i)] = all[static_cast<Eigen::Index>(coordinates[i])];
  return error;
}

}  // namespace qerr
