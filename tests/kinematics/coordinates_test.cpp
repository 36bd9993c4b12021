#include "qerr/kinematics/coordinates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(-r(2, 0)), std::atan2(r(1, 0), r(0, 0))};
}

TEST(Coordinates, RatesOfRollPitchYawAreTheirDerivatives) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Dice dice(seed);
    const Chain chain = make_chain(testing::random_robot(dice, {}), "", "");
    const Eigen::VectorXd q = testing::random_configuration(dice, chain);
    Eigen::Isometry3d pose;
    const Jacobian joints = joint_jacobian(chain, q, &pose);
    const double cosine = cosine_of_pitch(pose.linear());
    const Eigen::Vector3d here = roll_pitch_yaw(pose.linear());
    EXPECT_NEAR(cosine, std::cos(here.y()), 1e-7);
    if (cosine < 0.3) continue;
    const Eigen::MatrixXd rows = to_independent(
        chain,
        coordinate_rows({Coordinate::roll, Coordinate::pitch, Coordinate::yaw}, joints, pose.linear()));
    for (Eigen::Index i = 0; i < q.size(); ++i, ++compared) {
      const Eigen::Vector3d rate = testing::derivative_at_zero([&](double t) -> Eigen::Vector3d {
        Eigen::Vector3d change =
            roll_pitch_yaw(forward_kinematics(chain, q + t * Eigen::VectorXd::Unit(q.size(), i)).linear()) -
            here;
        for (double& angle : change) angle = std::remainder(angle, 2 * std::numbers::pi);
        return change;
      });
      EXPECT_LE((rate - rows.col(i)).cwiseAbs().maxCoeff(), 1e-7 / std::pow(cosine, 3)) << "seed " << seed;
    }
  }
  EXPECT_GT(compared, 300);
}

TEST(Coordinates, OfEulerAnglesHaveNoRatesAtTheGimbalLock) {
  Jacobian j = Jacobian::Zero(6, 1);
  j.col(0) << 1, 2, 3, 4, 5, 6;
  const Eigen::Matrix3d up =
      Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Eigen::Matrix3d lock = up;
  lock(0, 0) = lock(1, 0) = 0;
  const Eigen::MatrixXd rows = coordinate_rows(
      {Coordinate::roll, Coordinate::pitch, Coordinate::yaw, Coordinate::y, Coordinate::rz}, j, lock);
  EXPECT_EQ(rows(0, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rows(1, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rows(2, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(rows(3, 0), 2);
  EXPECT_EQ(rows(4, 0), 6);
}

TEST(Coordinates, NamesAreFoundAndUnknownOnesAreNot) {
  for (const CoordinateInfo& row : coordinate_list()) {
    EXPECT_EQ(find_coordinate(row.name), row.coordinate);
    EXPECT_EQ(info(row.coordinate).name, row.name);
    EXPECT_EQ(row.unit, is_position(row.coordinate) || row.coordinate == Coordinate::xyz ? "m" : "rad");
  }
  EXPECT_EQ(coordinate_list().size(), 11u);
  EXPECT_FALSE(find_coordinate("X"));
}

}  // namespace
}  // namespace qerr
