#include <gtest/gtest.h>

#include <cmath>

#include "qerr/bound/operational_error.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

/// Errors with the given sigmas along three random directions.
Eigen::Matrix3d covariance(testing::Dice& dice, const Eigen::Vector3d& sigmas) {
  const Eigen::Matrix3d turned = dice.frame(1).linear();
  return turned * sigmas.cwiseAbs2().asDiagonal() * turned.transpose();
}

TEST(ErrorEllipsoid, SubstitutedBackIsTheCovariance) {
  testing::Dice dice(1);
  for (int i = 0; i < 200; ++i) {
    const double scale = std::pow(10, dice.between(-12, 3));
    const Eigen::Matrix3d c =
        covariance(dice, scale * Eigen::Vector3d(1, dice.between(0, 1), dice.between(0, 1)));
    const ErrorEllipsoid e = error_ellipsoid(c);
    const Eigen::Matrix3d back =
        e.directions * e.semi_axes.cwiseAbs2().asDiagonal() * e.directions.transpose();
    EXPECT_LT((back - c).norm(), 1e-14 * c.norm());
    EXPECT_LT((e.directions.transpose() * e.directions - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GE(e.semi_axes[0], e.semi_axes[1]);
    EXPECT_GE(e.semi_axes[1], e.semi_axes[2]);
  }
}

TEST(ErrorEllipsoid, SigmaInEveryDirectionIsBetweenItsSemiAxes) {
  testing::Dice dice(2);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix3d c = covariance(dice, dice.vector(3, 0, 1));
    const ErrorEllipsoid e = error_ellipsoid(c);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d u = dice.direction();
      const double sigma = std::sqrt(u.dot(c * u));
      EXPECT_LE(sigma, e.semi_axes[0] * (1 + 1e-14));
      EXPECT_GE(sigma, e.semi_axes[2] * (1 - 1e-7) - 1e-8)
          << "a root of a small eigenvalue has half its digits";
    }
  }
}

TEST(ErrorEllipsoid, OfAnErrorAlongOneLineIsThatLine) {
  const Eigen::Vector3d line = Eigen::Vector3d(-2, 1, 2) / 3;
  const ErrorEllipsoid e = error_ellipsoid(4e-12 * line * line.transpose());
  EXPECT_NEAR(e.semi_axes[0], 2e-6, 1e-20);
  EXPECT_LT(e.semi_axes[1], 1e-13);
  EXPECT_NEAR(std::abs(e.directions.col(0).dot(line)), 1, 1e-15);
  EXPECT_GT(e.directions.col(0).maxCoeff(), 0.6) << "the largest component is positive";
}

TEST(ErrorEllipsoid, OfNoErrorIsAPoint) {
  const ErrorEllipsoid e = error_ellipsoid(Eigen::Matrix3d::Zero());
  EXPECT_EQ(e.semi_axes, Eigen::Vector3d::Zero());
  EXPECT_EQ(e.directions, Eigen::Matrix3d::Identity());
}

}  // namespace
}  // namespace qerr
