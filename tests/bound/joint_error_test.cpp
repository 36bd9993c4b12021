#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "qerr/bound/independent_error.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {
namespace {

TEST(JointError, DifferentialOfTheWamHasTheWorstCaseOfASingleGearAndLessSigma) {
  const Spec spec = read_spec(QERR_SOURCE_DIR "/configs/barrett_wam/spec.yaml");
  const JointError e = joint_error(spec.model.transmission);
  const double delta = 2 * std::numbers::pi / (4096 * 28.25);
  EXPECT_NEAR(e.worst_case[1], delta / 2, 1e-14 * delta);
  EXPECT_NEAR(e.sigma[1], delta / std::sqrt(12.0) / std::numbers::sqrt2, 1e-14 * delta);
  EXPECT_NEAR(e.worst_case[0], std::numbers::pi / (4096 * 42), 1e-14 * delta);
  EXPECT_EQ(e.mean, Eigen::VectorXd::Zero(7));
}

TEST(JointError, OfUncoupledJointsIsThatOfTheirEncoders) {
  const JointError e = joint_error(
      {{{0.2, Rounding::nearest, true}, {0.1, Rounding::nearest, true}}, Eigen::Matrix2d::Identity()});
  EXPECT_NEAR(e.sigma[0], 0.2 / std::sqrt(12.0), 1e-16);
  EXPECT_NEAR(e.sigma[1], 0.1 / std::sqrt(12.0), 1e-16);
  EXPECT_EQ(e.worst_case, Eigen::Vector2d(0.1, 0.05));
}

TEST(JointError, RoundingDownAddsItsMeanToTheWorstCaseAndNothingToSigma) {
  Transmission t{{{0.2, Rounding::down, true}, {0.1, Rounding::nearest, true}}, Eigen::Matrix2d::Identity()};
  t.coupling = (Eigen::Matrix2d() << 1, 2, -1, 1).finished();
  const JointError e = joint_error(t);
  // By hand: means C (-0.1, 0); half widths |C| (0.1, 0.05); variances (0.04 + 4 * 0.01)/12 and (0.04 +
  // 0.01)/12.
  EXPECT_NEAR(e.mean[0], -0.1, 1e-16);
  EXPECT_NEAR(e.mean[1], 0.1, 1e-16);
  EXPECT_NEAR(e.half_width[0], 0.2, 1e-16);
  EXPECT_NEAR(e.worst_case[0], 0.3, 1e-16);
  EXPECT_NEAR(e.worst_case[1], 0.25, 1e-16);
  EXPECT_NEAR(e.sigma[0], std::sqrt(0.08 / 12), 1e-16);
  EXPECT_NEAR(e.sigma[1], std::sqrt(0.05 / 12), 1e-16);
}

}  // namespace
}  // namespace qerr
