#include "qerr/bound/operational_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

const std::vector<Coordinate> pose_coordinates{Coordinate::x,  Coordinate::y,  Coordinate::z,
                                               Coordinate::rx, Coordinate::ry, Coordinate::rz};

OperationalModel random_model(Dice& dice, const ChainMix& mix, double finest, double coarsest) {
  OperationalModel model{make_chain(testing::random_robot(dice, mix), "", ""), {}, pose_coordinates};
  model.transmission = testing::random_transmission(dice, model.chain, finest, coarsest, dice.chance(0.5));
  return model;
}

/// Errors of the encoders, each at a fraction -1 .. 1 of its range: [-Delta/2, Delta/2], or [-Delta, 0] for
/// `down`.
Eigen::VectorXd encoder_errors(const Transmission& t, const Eigen::VectorXd& fraction) {
  return mean_errors(t) + 0.5 * resolutions(t).cwiseProduct(fraction);
}

Eigen::VectorXd corner(Eigen::Index size, unsigned long bits) {
  Eigen::VectorXd signs(size);
  for (Eigen::Index i = 0; i < size; ++i) signs[i] = (bits >> i) & 1 ? 1 : -1;
  return signs;
}

Eigen::Matrix<double, 6, 1> pose_error(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(estimate.linear() * truth.linear().transpose()));
  Eigen::Matrix<double, 6, 1> e;
  e << estimate.translation() - truth.translation(), turn.angle() * turn.axis();
  return e;
}

/// The largest error of x y z rx ry rz over all corners of the quantization box and `inside` random points in
/// it.
Eigen::VectorXd largest_pose_error(const OperationalModel& m, const Eigen::VectorXd& q, Dice& dice,
                                   int inside) {
  const Eigen::Isometry3d truth = forward_kinematics(m.chain, q);
  const Eigen::Index n = q.size();
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(6);
  const auto try_at = [&](const Eigen::VectorXd& fraction) {
    const Eigen::VectorXd error = m.transmission.coupling * encoder_errors(m.transmission, fraction);
    largest = largest.cwiseMax(pose_error(forward_kinematics(m.chain, q + error), truth).cwiseAbs());
  };
  for (unsigned long bits = 0; bits < 1ul << n; ++bits) try_at(corner(n, bits));
  for (int i = 0; i < inside; ++i) try_at(dice.vector(n, -1, 1));
  return largest;
}

// Equality to 1e-12 of the worst case: the vertices are summed in another order.
TEST(OperationalError, LinearWorstCaseIsAttainedAtAVertexAndNeverExceeded) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Dice dice(seed);
    const OperationalModel m = random_model(dice, {}, 1e-4, 1e-2);
    const Eigen::VectorXd q = testing::random_configuration(dice, m.chain);
    const OperationalError e = operational_error(m, q);
    const Eigen::MatrixXd sensed = jacobian(m.chain, q) * m.transmission.coupling;
    Eigen::VectorXd largest = Eigen::VectorXd::Zero(6);
    for (unsigned long bits = 0; bits < 1ul << q.size(); ++bits)
      largest =
          largest.cwiseMax((sensed * encoder_errors(m.transmission, corner(q.size(), bits))).cwiseAbs());
    EXPECT_LE((largest - e.worst_case).cwiseAbs().maxCoeff(), 1e-12 * e.worst_case.maxCoeff()) << seed;
    EXPECT_LE((e.mean - sensed * mean_errors(m.transmission)).cwiseAbs().maxCoeff(), 1e-15) << seed;
    EXPECT_LE((e.half_width + e.mean.cwiseAbs() - e.worst_case).cwiseAbs().maxCoeff(), 1e-15) << seed;
  }
}

// sigma of N = 20000 samples scatters by at most sigma/sqrt(2N) (its kurtosis is below 3); allowed: four
// times that, for covariances four times sqrt(2/N) sigma_i sigma_j.
TEST(OperationalError, CovarianceIsThatOfUniformNoiseThroughTheJacobian) {
  constexpr int count = 20000;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Dice dice(seed);
    const OperationalModel m = random_model(dice, {}, 1e-3, 1e-2);
    const Eigen::VectorXd q = testing::random_configuration(dice, m.chain);
    const OperationalError e = operational_error(m, q);
    const Eigen::MatrixXd sensed = jacobian(m.chain, q) * m.transmission.coupling;
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(6, 6);
    for (int i = 0; i < count; ++i) {
      const Eigen::VectorXd x =
          sensed * encoder_errors(m.transmission, dice.vector(q.size(), -1, 1)) - e.mean;
      products += x * x.transpose();
    }
    const Eigen::MatrixXd sampled = products / count, expected = e.weighted * e.weighted.transpose() / 12;
    for (Eigen::Index i = 0; i < 6; ++i) {
      EXPECT_NEAR(std::sqrt(sampled(i, i)), e.sigma[i], 4 * e.sigma[i] / std::sqrt(2.0 * count) + 1e-18)
          << seed;
      for (Eigen::Index j = 0; j < i; ++j)
        EXPECT_NEAR(sampled(i, j), expected(i, j),
                    4 * std::sqrt(2.0 / count) * e.sigma[i] * e.sigma[j] + 1e-30);
    }
  }
}

// The linear bound (paper, Eq. 17) is exceeded here; the rigorous one must not be. Tolerance: 1e-12 for
// rounding.
TEST(OperationalError, RigorousBoundHoldsAtEveryCornerAndInsideWhereTheLinearOneFails) {
  int linear_failures = 0;
  Eigen::VectorXd used = Eigen::VectorXd::Zero(6);
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Dice dice(seed);
    ChainMix mix;
    mix.joints = 1 + seed % 7;
    const OperationalModel m = random_model(dice, mix, 1e-3, 0.1);
    const Eigen::VectorXd q = testing::random_configuration(dice, m.chain);
    const OperationalError e = operational_error(m, q);
    const Eigen::VectorXd largest = largest_pose_error(m, q, dice, 1000);
    for (Eigen::Index i = 0; i < 6; ++i) {
      EXPECT_LE(largest[i], e.rigorous[i] + 1e-12) << "seed " << seed << " coordinate " << i;
      linear_failures += largest[i] > e.worst_case[i] + 1e-12;
      if (e.rigorous[i] > 1e-6) used[i] = std::max(used[i], largest[i] / e.rigorous[i]);
    }
  }
  EXPECT_GT(linear_failures, 500) << "of 1800: with no failure of (17) this test would show nothing";
  EXPECT_GT(used.minCoeff(), 0.9) << "a bound far too wide would pass as well: " << used.transpose();
}

TEST(OperationalError, RigorousBoundTendsToTheLinearOneWithTheResolutionSquared) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Dice dice(seed);
    OperationalModel m = random_model(dice, {}, 1e-3, 1e-2);
    const Eigen::VectorXd q = testing::random_configuration(dice, m.chain);
    const OperationalError coarse = operational_error(m, q);
    for (Encoder& encoder : m.transmission.encoders) encoder.resolution /= 16;
    const OperationalError fine = operational_error(m, q);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double remainder = coarse.rigorous[i] - coarse.worst_case[i];
      EXPECT_GE(remainder, 0);
      EXPECT_LE(fine.rigorous[i] - fine.worst_case[i], remainder / 256 * (1 + 1e-9) + 1e-17);
    }
  }
}

TEST(OperationalError, IsExactlyLinearForPrismaticJoints) {
  Dice dice(5);
  ChainMix mix;
  mix.prismatic = 1;
  const OperationalModel m = random_model(dice, mix, 1e-2, 0.1);
  const OperationalError e = operational_error(m, testing::random_configuration(dice, m.chain));
  EXPECT_EQ(e.rigorous, e.worst_case);
  EXPECT_EQ(e.worst_case.tail(3), Eigen::Vector3d::Zero());
}

TEST(OperationalError, AnglesAreUnboundedAtTheGimbalLockWithoutANaN) {
  RobotModel robot{"lock", "lock.urdf", {"base", "tip"}, {}, {}};
  Joint joint;
  joint.name = "a";
  joint.type = JointType::revolute;
  joint.parent = "base";
  joint.child = "tip";
  joint.axis = Eigen::Vector3d::UnitZ();
  joint.origin.linear() << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // pitch 90 deg
  robot.joints = {joint};
  const OperationalModel m{make_chain(robot, "", ""),
                           {{{0.01, Rounding::down, true}}, Eigen::MatrixXd::Identity(1, 1)},
                           {Coordinate::roll, Coordinate::pitch, Coordinate::yaw, Coordinate::rx}};
  const OperationalError e = operational_error(m, Eigen::VectorXd::Zero(1));
  for (const Eigen::Index i : {0, 1, 2}) {
    EXPECT_EQ(e.worst_case[i], std::numeric_limits<double>::infinity());
    EXPECT_EQ(e.sigma[i], std::numeric_limits<double>::infinity());
  }
  EXPECT_EQ(e.rigorous[1], std::numeric_limits<double>::infinity()) << "no rigorous bound of Euler angles";
  EXPECT_NEAR(e.worst_case[3], 0.01, 1e-15);
  for (const Eigen::VectorXd& v : {e.mean, e.half_width, e.worst_case, e.rigorous, e.sigma})
    EXPECT_FALSE(v.hasNaN());
  EXPECT_EQ(e.cosine_of_pitch, 0);
}

}  // namespace
}  // namespace qerr
