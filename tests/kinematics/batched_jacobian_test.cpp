#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "kinematics/sampler.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;
namespace fs = std::filesystem;

/// Largest distance along the chain: the scale of rounding errors.
double extent(const Chain& chain, const Eigen::MatrixXd& q) {
  double sum = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) {
    sum += joint.origin.translation().norm();
    if (joint.prismatic)
      sum += (joint.multiplier * q.row(static_cast<Eigen::Index>(joint.coordinate)).array() + joint.offset)
                 .abs()
                 .maxCoeff();
  }
  return sum;
}

/// Largest difference between the batched Jacobians of 64 configurations and the scalar ones, over the
/// extent.
double deviation(const Chain& chain, InstructionSet set, Dice& dice) {
  const std::size_t independent = chain.independent.size(), joints = chain.joints.size();
  AlignedNumbers q(independent * batch_size), to(6 * joints * batch_size);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = dice.between(-3.2, 3.2);
  BatchedJacobian batched(chain, set);
  batched(q.data(), to.data());
  const Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> points(
      q.data(), static_cast<Eigen::Index>(independent), batch_size);
  double worst = 0;
  for (Eigen::Index c = 0; c < points.cols(); ++c) {
    const Jacobian expected = joint_jacobian(chain, points.col(c));
    for (std::size_t k = 0; k < joints; ++k)
      for (std::size_t row = 0; row < 6; ++row) {
        const double entry = to[(6 * k + row) * batch_size + static_cast<std::size_t>(c)];
        worst = std::max(
            worst, std::abs(entry - expected(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k))));
      }
  }
  return worst / std::max(1.0, extent(chain, points));
}

void expect_agreement(const Chain& chain, std::uint64_t seed, double tolerance, const std::string& what) {
  Dice dice(seed);
  for (const InstructionSet set : available_instruction_sets())
    EXPECT_LT(deviation(chain, set, dice), tolerance) << what << ", " << name_of(set);
}

std::vector<std::string> ends(const RobotModel& robot) {
  std::vector<std::string> tips;
  for (const std::string& link : robot.links) {
    bool leaf = true;
    for (const Joint& joint : robot.joints) leaf = leaf && joint.parent != link;
    if (leaf) tips.push_back(link);
  }
  return tips;
}

std::size_t expect_agreement_below(const fs::path& folder) {
  std::size_t chains = 0;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(folder)) {
    if (file.path().extension() != ".urdf" || file.path().string().find("nasty") != std::string::npos)
      continue;
    const RobotModel robot = read_urdf(file.path().string());
    for (const std::string& tip : ends(robot)) {
      Chain chain;
      try {
        chain = make_chain(robot, "", tip);
      } catch (const std::exception&) {
        continue;  // no moving joint between the links, or a floating one
      }
      expect_agreement(chain, ++chains, 5e-15, file.path().filename().string() + " " + tip);
    }
  }
  return chains;
}

TEST(BatchedJacobian, EqualsTheScalarOneOnEveryShippedRobot) {
  EXPECT_GE(expect_agreement_below(fs::path(QERR_SOURCE_DIR) / "configs"), 8u);
}

TEST(BatchedJacobian, EqualsTheScalarOneOnEveryChainOfRealRobots) {
  const fs::path robots = fs::path(QERR_SOURCE_DIR) / "../shared/robots";
  if (!fs::exists(robots)) GTEST_SKIP() << "no ../shared/robots here";
  EXPECT_GE(expect_agreement_below(robots), 20u);
}

RC_GTEST_PROP(BatchedJacobian, EqualsTheScalarOneOnRandomChains, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const ChainMix mix{*rc::gen::inRange<std::size_t>(1, 40)};
  const Chain chain = make_chain(random_robot(dice, mix), "", "");
  for (const InstructionSet set : available_instruction_sets())
    RC_ASSERT(deviation(chain, set, dice) < 2e-15 * static_cast<double>(chain.joints.size() + 2));
}

/// A chain whose fixed rotations are multiples of 90 degrees plus up to `off`, with axes in any direction.
Chain squared_chain(Dice& dice, std::size_t joints, double off) {
  RobotModel robot = random_robot(dice, ChainMix{joints, 0.25, 0.2, 0.3});
  for (Joint& joint : robot.joints) {
    const auto quarter = [&] {
      return std::floor(dice.between(-2, 3)) * std::numbers::pi / 2 + dice.between(-off, off);
    };
    Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
    for (Eigen::Index i = 0; i < 3; ++i)
      if (dice.chance(0.4)) origin.translation()[i] = dice.between(-0.5, 0.5);
    origin.rotate(Eigen::AngleAxisd(quarter(), Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(quarter(), Eigen::Vector3d::UnitZ()));
    joint.origin = origin;
    joint.axis = Eigen::Vector3d::Zero();
    joint.axis[static_cast<Eigen::Index>(dice.below(3))] = dice.chance(0.5) ? 1 : -1;
  }
  return make_chain(robot, "", "");
}

// Multiples of 90 degrees, for which the folding is specialized, and angles near them, for which it must not
// be.
RC_GTEST_PROP(BatchedJacobian, EqualsTheScalarOneAtAndNearRightAngles, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const double off = *rc::gen::element(0.0, 1e-16, 1e-15, 5e-12, 1e-9, 3.7e-6, 1e-3, 0.02);
  const Chain chain = squared_chain(dice, *rc::gen::inRange<std::size_t>(1, 12), off);
  for (const InstructionSet set : available_instruction_sets())
    RC_ASSERT(deviation(chain, set, dice) < 4e-14);
}

TEST(FoldedChain, FoldsRightAnglesOnly) {
  RobotModel robot{"two", "two.urdf", {"base", "a", "tip"}, {}, {}};
  enum class Tilt { none, right, general };
  const auto tilt_of = [&](double angle) {
    robot.joints.clear();
    for (const char* child : {"a", "tip"}) {
      Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
      if (*child == 't') origin.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()));
      robot.joints.push_back({std::string("to_") + child,
                              JointType::revolute,
                              *child == 'a' ? "base" : "a",
                              child,
                              origin,
                              Eigen::Vector3d::UnitZ(),
                              {},
                              {},
                              {}});
    }
    const FoldedJoint joint = fold(make_chain(robot, "", ""), false).joints[1];
    return joint.tilts ? Tilt::general : joint.right_angle ? Tilt::right : Tilt::none;
  };
  EXPECT_EQ(tilt_of(std::numbers::pi / 2), Tilt::right);
  EXPECT_EQ(tilt_of(-std::numbers::pi / 2), Tilt::right);
  EXPECT_EQ(tilt_of(std::numbers::pi), Tilt::none);
  EXPECT_EQ(tilt_of(0), Tilt::none);
  EXPECT_EQ(tilt_of(1.57079632679), Tilt::general) << "5e-12 off, as in the UR5's file";
  EXPECT_EQ(tilt_of(1.5708), Tilt::general);
  EXPECT_EQ(tilt_of(1e-9), Tilt::general);
}

}  // namespace
}  // namespace qerr
