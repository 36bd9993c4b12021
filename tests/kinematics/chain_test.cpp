#include "qerr/kinematics/chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "qerr/core/error.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

Joint link_joint(const std::string& name, JointType type, const std::string& parent,
                 const std::string& child) {
  Joint joint;
  joint.name = name;
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  joint.origin.translation() << 1, 0, 0;
  joint.axis = Eigen::Vector3d::UnitZ();
  return joint;
}

/// base -a-> one -b-> two -c-> left, two -d-> right: every joint 1 m from the one before, about z.
RobotModel fork() {
  RobotModel robot{"fork", "fork.urdf", {"base", "one", "two", "left", "right"}, {}, {}};
  robot.joints = {link_joint("a", JointType::revolute, "base", "one"),
                  link_joint("b", JointType::revolute, "one", "two"),
                  link_joint("c", JointType::revolute, "two", "left"),
                  link_joint("d", JointType::prismatic, "two", "right")};
  return robot;
}

std::string message_of(const RobotModel& robot, const std::string& base, const std::string& tip) {
  try {
    make_chain(robot, base, tip);
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::input);
    return e.what();
  }
  return "";
}

TEST(Chain, OfTipsHaveAllJointsAndTheirPairsNoneInCommon) {
  const std::vector<NamedTip> tips = make_chains(fork(), "", {{"l", "left"}, {"r", "right"}});
  ASSERT_EQ(tips.size(), 4u);
  for (const NamedTip& tip : tips)
    EXPECT_EQ(testing::joint_names(tip.chain), (std::vector<std::string>{"a", "b", "c", "d"})) << tip.name;
  EXPECT_EQ(tips[3].name, "r-l");
  const Eigen::Vector4d q(0.3, -0.4, 0.5, 0.2);
  const Eigen::Isometry3d relative =
      forward_kinematics(tips[0].chain, q).inverse() * forward_kinematics(tips[1].chain, q);
  EXPECT_TRUE(forward_kinematics(tips[3].chain, q).isApprox(relative, 1e-15));
  EXPECT_TRUE(jacobian(tips[3].chain, q).leftCols<2>().isZero(0)) << "a and b move both";
  EXPECT_FALSE(jacobian(tips[3].chain, q).col(2).isZero(1e-3));
}

TEST(Chain, MimicFoldsIntoItsMaster) {
  RobotModel robot = fork();
  robot.joints[1].mimic = Mimic{"a", -0.5, 0.25};  // b = 0.25 - a/2
  const Chain chain = make_chain(robot, "base", "left");
  ASSERT_EQ(testing::joint_names(chain), (std::vector<std::string>{"a", "c"}));
  ASSERT_EQ(chain.joints.size(), 3u);
  // By hand: tip = (1,0) + Rz(a)(1,0) + Rz(a+b)(1,0); its rotation is a + b + c.
  const double a = 0.3, c = -0.7, b = 0.25 - 0.5 * a;
  const Eigen::Isometry3d pose = forward_kinematics(chain, Eigen::Vector2d(a, c));
  EXPECT_NEAR(pose(0, 3), 1 + std::cos(a) + std::cos(a + b), 1e-15);
  EXPECT_NEAR(pose(1, 3), std::sin(a) + std::sin(a + b), 1e-15);
  const Jacobian j = jacobian(chain, Eigen::Vector2d(a, c));
  EXPECT_NEAR(j(0, 0), -std::sin(a) - 0.5 * std::sin(a + b), 1e-15);
  EXPECT_NEAR(j(1, 0), std::cos(a) + 0.5 * std::cos(a + b), 1e-15);
  EXPECT_NEAR(j(5, 0), 0.5, 1e-15);
  EXPECT_NEAR(j(5, 1), 1, 1e-15);
}

TEST(Chain, MasterOffTheChainIsIndependent) {
  RobotModel robot = fork();
  robot.joints[2].mimic = Mimic{"d", 2, 0};  // c follows the slide on the other branch
  const Chain chain = make_chain(robot, "one", "left");
  ASSERT_EQ(testing::joint_names(chain), (std::vector<std::string>{"b", "d"}));
  EXPECT_FALSE(chain.independent[1].on_chain);
  EXPECT_TRUE(chain.independent[1].prismatic());
  EXPECT_FALSE(chain.joints[1].prismatic);
  EXPECT_EQ(jacobian(chain, Eigen::Vector2d(0.1, 0.2))(5, 1), 2);
}

TEST(Chain, FindsItsJointsByName) {
  RobotModel robot = fork();
  robot.joints[2].mimic = Mimic{"d", 2, 0};  // c follows the slide on the other branch
  const Chain chain = make_chain(robot, "one", "left");
  EXPECT_EQ(independent_index(chain, "b"), 0u);
  EXPECT_EQ(independent_index(chain, "d"), 1u);
  EXPECT_THROW(independent_index(chain, "c"), std::out_of_range) << "a mimic";
  EXPECT_THROW(independent_index(chain, "a"), std::out_of_range) << "below the base";
  EXPECT_EQ(find_joint(chain, "b"), std::optional<std::size_t>{0});
  EXPECT_EQ(find_joint(chain, "c"), std::optional<std::size_t>{1});
  EXPECT_FALSE(find_joint(chain, "d")) << "a master beside the chain";
}

TEST(Chain, MasterAfterItsMimicKeepsItsPlace) {
  RobotModel robot = fork();
  robot.joints[0].mimic = Mimic{"c", 1, 0};
  const Chain chain = make_chain(robot, "base", "left");
  EXPECT_EQ(testing::joint_names(chain), (std::vector<std::string>{"b", "c"}));
  EXPECT_TRUE(chain.independent[1].on_chain);
}

TEST(Chain, IsPartOfATree) {
  const Chain chain = make_chain(fork(), "one", "right");
  EXPECT_EQ(chain.base, "one");
  EXPECT_EQ(chain.tip, "right");
  ASSERT_EQ(testing::joint_names(chain), (std::vector<std::string>{"b", "d"}));
  const Eigen::Isometry3d pose = forward_kinematics(chain, Eigen::Vector2d(std::numbers::pi / 2, 0.5));
  EXPECT_NEAR(pose(0, 3), 1, 1e-15);
  EXPECT_NEAR(pose(1, 3), 1, 1e-15);
  EXPECT_NEAR(pose(2, 3), 0.5, 1e-15);
}

TEST(Chain, PassesThroughTheCommonAncestorOfAnyTwoLinks) {
  RobotModel robot = fork();
  robot.joints[0].origin.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  robot.joints[2].origin.rotate(Eigen::AngleAxisd(-0.8, Eigen::Vector3d::UnitY()));
  robot.joints[2].axis = Eigen::Vector3d(1, 2, -2) / 3;
  robot.joints[2].mimic = Mimic{"b", -0.5, 0.25};
  // From the root, with the values of b and d; c follows b.
  const auto pose = [&](const std::string& tip, const std::vector<double>& q) {
    return forward_kinematics(
        make_chain(robot, "base", tip),
        Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  };
  for (const double b : {-2.0, 0.0, 1.1}) {
    const Eigen::Isometry3d left = pose("left", {0.4, b}), right = pose("right", {0.4, b, 0.2});
    const Chain across = make_chain(robot, "left", "right"), up = make_chain(robot, "left", "base");
    ASSERT_EQ(testing::joint_names(across), (std::vector<std::string>{"b", "d"})) << "a and b cancel";
    EXPECT_LT(
        (forward_kinematics(across, Eigen::Vector2d(b, 0.2)).matrix() - (left.inverse() * right).matrix())
            .norm(),
        1e-14);
    ASSERT_EQ(testing::joint_names(up), (std::vector<std::string>{"b", "a"}));
    EXPECT_LT((forward_kinematics(up, Eigen::Vector2d(b, 0.4)).matrix() - left.inverse().matrix()).norm(),
              1e-14);
  }
}

TEST(Chain, ALoadIsAllThatTheJointMovesWhenTheBaseIsHeld) {
  RobotModel robot = fork();
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    robot.inertias.push_back({std::pow(2, i), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()});
  const Chain across = make_chain(robot, "left", "right");
  ASSERT_EQ(across.joints.size(), 2u);
  // Held at `left` (8 kg), joint c moves base, one and two (7 kg), d moves `right`.
  EXPECT_EQ(across.joints[0].load.mass, 7);
  EXPECT_EQ(across.joints[1].load.mass, 16);
  // Origins of `two`, `one` and `base` at 1, 2 and 3 m from joint c, at which the frame of the load is.
  EXPECT_NEAR(across.joints[0].load.center.x(), -(4 * 1 + 2 * 2 + 1 * 3) / 7.0, 1e-15);
  ASSERT_EQ(warnings_about(robot, across).size(), 1u) << "the robot is held elsewhere";
  EXPECT_EQ(make_chain(robot, "", "right").joints[1].load.mass, 4 + 8) << "from the root, as ever";
  EXPECT_TRUE(warnings_about(robot, make_chain(robot, "", "right")).empty());
}

TEST(Chain, SeveralLeavesNeedATip) {
  const std::string message = message_of(fork(), "", "");
  EXPECT_NE(message.find("robot.tip"), std::string::npos) << message;
  EXPECT_NE(message.find("'left' (3 moving joints), 'right' (3)"), std::string::npos) << message;
}

TEST(Chain, FloatingAndPlanarJointsOnTheChainAreRejectedByName) {
  for (const auto& [type, word] :
       {std::pair{JointType::floating, "floating"}, {JointType::planar, "planar"}}) {
    RobotModel robot = fork();
    robot.joints[1].type = type;
    const std::string message = message_of(robot, "", "left");
    EXPECT_NE(message.find("joint 'b'"), std::string::npos) << message;
    EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_EQ(make_chain(robot, "two", "left").joints.size(), 1u) << "not on the chain";
  }
}

TEST(Chain, UnknownLinksAndChainsWithoutMotionAreRejected) {
  EXPECT_NE(message_of(fork(), "bse", "left").find("'base'"), std::string::npos) << "suggests a name";
  EXPECT_NE(message_of(fork(), "", "middle").find("robot.tip"), std::string::npos);
  EXPECT_NE(message_of(fork(), "two", "two").find("robot.tip"), std::string::npos);
  RobotModel still = fork();
  still.joints[2].type = JointType::fixed;
  EXPECT_NE(message_of(still, "two", "left").find("no moving joint"), std::string::npos);
}

}  // namespace
}  // namespace qerr
