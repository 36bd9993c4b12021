#include <gtest/gtest.h>

#include "qerr/core/error.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/robot_model.hpp"
#include "support/urdf_text.hpp"

namespace qerr {
namespace {

using namespace testing::urdf;

std::string link(const std::string& name) { return "<link name='" + name + "'/>"; }

std::string fixed(const std::string& parent, const std::string& child) {
  return link(child) + joint("to_" + child, "fixed", parent, child, "");
}

std::vector<std::string> tips(const RobotModel& robot, const std::string& base = "") {
  std::vector<std::string> names;
  for (const TreeEnd& end : tree_ends(robot, base)) names.push_back(end.tip);
  return names;
}

/// An arm of two joints with frames at its end, a finger beyond it, a wheel and a mast.
std::string arm_with_frames() {
  return robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "revolute", "b", "c") +
               fixed("c", "marker") + fixed("c", "left_ee") + fixed("c", "wristCamera") +
               fixed("c", "tool0") + fixed("a", "mast") + link("wheel") +
               joint("drive", "continuous", "a", "wheel", ""));
}

TEST(TreeEnds, AreSortedByMovingJointsThenByName) {
  EXPECT_EQ(tips(read(arm_with_frames())),
            (std::vector<std::string>{"tool0", "left_ee", "marker", "wheel", "wristCamera", "mast"}));
}

TEST(TreeEnds, NameTheMovingJointsThatLeadToThem) {
  const RobotModel robot = read(arm_with_frames());
  const TreeEnd end = tree_ends(robot).front();
  EXPECT_EQ(end.base, "a");
  EXPECT_EQ(end.kind, EndKind::tool);
  ASSERT_EQ(end.joints.size(), 2u);
  EXPECT_EQ(robot.joints[end.joints[0]].name, "ab");
  EXPECT_EQ(robot.joints[end.joints[1]].name, "bc");
}

TEST(TreeEnds, BelowABaseAreThoseOfItsBranch) {
  const RobotModel robot = read(arm_with_frames());
  EXPECT_EQ(tips(robot, "wheel"), std::vector<std::string>{"wheel"});
  const std::vector<TreeEnd> ends = tree_ends(robot, "b");
  EXPECT_EQ(ends.size(), 4u);
  EXPECT_EQ(ends.front().base, "b");
  EXPECT_EQ(ends.front().joints.size(), 1u);
}

TEST(TreeEnds, BeginBelowAFloatingJoint) {
  const RobotModel robot = read(testing::urdf::robot(links + joint("free", "floating", "a", "b", "") +
                                                     joint("bc", "revolute", "b", "c")));
  const TreeEnd end = tree_ends(robot).front();
  EXPECT_EQ(end.base, "b");
  EXPECT_EQ(end.joints.size(), 1u);
  EXPECT_EQ(natural_base(robot, "c"), "b");
  EXPECT_EQ(make_chain(robot, end.base, end.tip).joints.size(), 1u);
}

TEST(TreeEnds, AreNamedInThatOrderWhereATipIsMissing) {
  const RobotModel robot = read(arm_with_frames());
  try {
    make_chain(robot, "", "");
    FAIL() << "a tip was guessed";
  } catch (const Error& e) {
    EXPECT_NE(
        std::string(e.what()).find("'tool0' (2 moving joints), 'left_ee' (2), 'marker' (2), 'wheel' (1)"),
        std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace qerr
