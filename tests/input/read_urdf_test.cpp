#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <numbers>

#include "qerr/core/error.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "support/random_chain.hpp"
#include "support/urdf_text.hpp"

namespace qerr {
namespace {

using namespace testing::urdf;

TEST(ReadUrdf, ReadsATreeWithEveryJointType) {
  const RobotModel m = read(
      robot("<link name='w'/>" + links + "<link name='d'/><link name='e'/><link name='f'/>" +
            joint("1", "revolute", "w", "a") + joint("2", "continuous", "a", "b", "") +
            joint("3", "prismatic", "b", "c") + joint("4", "fixed", "c", "d", "<axis xyz='0 0 0'/>") +
            joint("5", "floating", "c", "e", "") + joint("6", "planar", "c", "f", "<axis xyz='0 0 1'/>")));
  EXPECT_EQ(m.name, "r");
  EXPECT_EQ(m.file, "r.urdf");
  EXPECT_EQ(m.links, (std::vector<std::string>{"w", "a", "b", "c", "d", "e", "f", "6/x", "6/y"}));
  ASSERT_EQ(m.joints.size(), 8u);
  const JointType types[] = {JointType::revolute,  JointType::continuous, JointType::prismatic,
                             JointType::fixed,     JointType::floating,   JointType::prismatic,
                             JointType::prismatic, JointType::continuous};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(m.joints[i].type, types[i]);
  EXPECT_EQ(m.joints[2].parent, "b");
  EXPECT_EQ(m.joints[2].child, "c");
  EXPECT_EQ(m.joints[0].limits->lower, -1);
  EXPECT_EQ(m.joints[0].limits->upper, 2);
  EXPECT_FALSE(m.joints[1].limits);
  EXPECT_EQ(m.joints[0].axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(m.joints[5].axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(m.joints[6].axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(m.joints[7].axis, Eigen::Vector3d::UnitZ());
  ASSERT_EQ(warnings(m).size(), 1u);
  EXPECT_NE(warnings(m)[0].find("'6/*'"), std::string::npos) << warnings(m)[0];
}

TEST(ReadUrdf, APlanarJointIsAPositionInItsPlaneAndAYaw) {
  for (const std::string normal : {"0 0 1", "0 0 -1", "1 2 -2"}) {
    const RobotModel m =
        read(robot(links + joint("base", "planar", "a", "b", "<axis xyz='" + normal + "'/>") +
                   joint("arm", "revolute", "b", "c", "<origin xyz='0.3 0 0.1'/>")));
    const Chain chain = make_chain(m, "a", "c");
    ASSERT_EQ(testing::joint_names(chain), (std::vector<std::string>{"base/x", "base/y", "base/yaw", "arm"}));
    const auto pose = [&](double x, double y, double yaw) {
      return forward_kinematics(chain, Eigen::Vector4d(x, y, yaw, 0));
    };
    Eigen::Vector3d n = chain.joints[2].axis;
    const Eigen::Vector3d at_rest = pose(0, 0, 0).translation();
    // Whatever x and y are, they are at right angles in the plane, and right-handed about its normal.
    const Eigen::Vector3d along_x = pose(1, 0, 0).translation() - at_rest,
                          along_y = pose(0, 1, 0).translation() - at_rest;
    EXPECT_LT((along_x.cross(along_y) - n).norm(), 1e-15) << normal;
    const Eigen::Vector3d moved = pose(0.2, -0.5, 0.7).translation();
    const Eigen::Vector3d expected =
        0.2 * along_x - 0.5 * along_y + Eigen::AngleAxisd(0.7, n) * Eigen::Vector3d(0.3, 0, 0.1);
    EXPECT_LT((moved - expected).norm(), 1e-15) << normal;
  }
}

TEST(ReadUrdf, ExpandsATemplateWhereXacroIsInstalled) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(::testing::TempDir()) / "qerr_xacro";
  fs::create_directories(folder);
  const std::string file = (folder / "arm it's.xacro").string();
  std::ofstream(file) << "<robot name='t'><xacro:arm/></robot>";
  std::ofstream(folder / "expanded.urdf") << "<robot name='t'><link name='a'/></robot>";
  // Instead of the program: it is given the template's path, and writes to standard output.
  std::ofstream(folder / "xacro") << "#!/bin/sh\ntest \"$1\" = -- && test -f \"$2\" && cat '" +
                                         (folder / "expanded.urdf").string() + "'\n";
  fs::permissions(folder / "xacro", fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.string() + ':' + path).c_str(), 1);
  EXPECT_EQ(read_urdf(file).links, std::vector<std::string>{"a"});
  std::ofstream(folder / "xacro") << "#!/bin/sh\nexit 3\n";
  EXPECT_THROW(read_urdf(file), Error);
  setenv("PATH", path.c_str(), 1);
  fs::remove_all(folder);
}

TEST(ReadUrdf, StoresThePlaceOfEachJoint) {
  const RobotModel m =
      read(robot(links + joint("x", "fixed", "a", "b", "") + "\n\n  " + joint("y", "fixed", "b", "c")));
  EXPECT_EQ(m.joints[0].place.line, 2);
  EXPECT_EQ(m.joints[0].place.column, static_cast<int>(links.size()) + 1);
  EXPECT_EQ(m.joints[1].place.line, 4);
  EXPECT_EQ(m.joints[1].place.column, 3);
  EXPECT_EQ(m.joints[1].place.file, "r.urdf");
}

TEST(ReadUrdf, RotatesByRollPitchYawToFullPrecision) {
  const RobotModel m = read(inside_joint("<origin xyz='1.1 -2e-3 .5' rpy='0.1 0.2 0.3'/>", "fixed"));
  EXPECT_EQ(m.joints[0].origin.translation(), Eigen::Vector3d(1.1, -2e-3, .5));
  using Eigen::AngleAxis;
  using Vector = Eigen::Matrix<long double, 3, 1>;
  const Eigen::Matrix<long double, 3, 3> expected =
      (AngleAxis<long double>(0.3, Vector::UnitZ()) * AngleAxis<long double>(0.2, Vector::UnitY()) *
       AngleAxis<long double>(0.1, Vector::UnitX()))
          .toRotationMatrix();
  EXPECT_LT((m.joints[0].origin.linear() - expected.cast<double>()).cwiseAbs().maxCoeff(), 3e-16);
}

TEST(ReadUrdf, ReadsMimicWithItsDefaults) {
  const std::string given = limit + "<mimic joint='bc' multiplier='-2.5' offset='.25'/>";
  const RobotModel m =
      read(robot(links + joint("ab", "revolute", "a", "b", given) + joint("bc", "continuous", "b", "c")));
  ASSERT_TRUE(m.joints[0].mimic);
  EXPECT_EQ(m.joints[0].mimic->joint, "bc");
  EXPECT_EQ(m.joints[0].mimic->multiplier, -2.5);
  EXPECT_EQ(m.joints[0].mimic->offset, .25);
  const RobotModel plain =
      read(robot(links + joint("ab", "revolute", "a", "b", limit + "<mimic joint='bc'/>") +
                 joint("bc", "prismatic", "b", "c")));
  EXPECT_EQ(plain.joints[0].mimic->multiplier, 1);
  EXPECT_EQ(plain.joints[0].mimic->offset, 0);
}

TEST(ReadUrdf, NormalizesAnAxisWithAWarning) {
  const RobotModel m = read(inside_joint("<axis xyz='0 1 1'/>", "continuous"));
  EXPECT_NEAR(m.joints[0].axis.y(), std::sqrt(0.5), 3e-16);
  EXPECT_NEAR(m.joints[0].axis.norm(), 1, 1e-15);
  ASSERT_EQ(warnings(m).size(), 1u);
  EXPECT_NE(warnings(m)[0].find("r.urdf:3:1: joint 'ab': the axis '0 1 1' has norm 1.414"),
            std::string::npos);
  const RobotModel huge = read(inside_joint("<axis xyz='0 1e300 1e300'/>", "continuous"));
  EXPECT_NEAR(huge.joints[0].axis.y(), std::sqrt(0.5), 1e-15);
}

TEST(ReadUrdf, AcceptsRoundedUnitVectors) {
  const RobotModel m = read(inside_joint("<axis xyz='0 0.7071067 0.7071068'/>", "continuous"));
  EXPECT_TRUE(warnings(m).empty());
  EXPECT_NEAR(m.joints[0].axis.norm(), 1, 1e-15);
}

TEST(ReadUrdf, LeavesLimitsEmptyWhereNoneAreGiven) {
  const RobotModel without = read(inside_joint(""));
  EXPECT_FALSE(without.joints[0].limits);
  ASSERT_EQ(warnings(without).size(), 1u);
  EXPECT_NE(warnings(without)[0].find("joint 'ab': a revolute joint should have a <limit>"),
            std::string::npos);
  const RobotModel effort_only = read(inside_joint("<limit effort='1' velocity='1'/>"));
  EXPECT_FALSE(effort_only.joints[0].limits);
  EXPECT_TRUE(warnings(effort_only).empty());
  EXPECT_FALSE(read(inside_joint(limit, "continuous")).joints[0].limits);
  const RobotModel half = read(inside_joint("<limit upper='2' effort='1' velocity='1'/>"));
  EXPECT_EQ(half.joints[0].limits->lower, 0);
  EXPECT_EQ(half.joints[0].limits->upper, 2);
}

TEST(ReadUrdf, WarnsOfAMimicWithoutEffect) {
  const RobotModel fixed = read(inside_joint("<mimic joint='nobody'/>", "fixed"));
  EXPECT_FALSE(fixed.joints[0].mimic);
  EXPECT_EQ(warnings(fixed).size(), 1u);
  const RobotModel zero =
      read(robot(links + joint("ab", "continuous", "a", "b", "<mimic joint='bc' multiplier='0'/>") +
                 joint("bc", "continuous", "b", "c", "")));
  EXPECT_EQ(zero.joints[0].mimic->multiplier, 0);
  EXPECT_EQ(warnings(zero).size(), 1u);
}

TEST(ReadUrdf, ReadsARobotWhoseNameIsEmptyWithAWarning) {
  const RobotModel m = read("<robot name=''><link name='a'/></robot>");
  EXPECT_EQ(m.name, "");
  EXPECT_EQ(warnings(m).size(), 1u);
}

TEST(ReadUrdf, IgnoresElementsOtherThanKinematics) {
  const RobotModel m = read(
      "\xEF\xBB\xBF<?xml version='1.0' encoding='ISO-8859-1'?><!-- \xC3\xA9 ${prefix} --><robot name='r' "
      "version='1.0'>"
      "<material name='m'/><ros2_control name='x'><joint name='a'><offset>1</offset></joint></ros2_control>"
      "<link name='a' "
      "drake:x='1'><visual><geometry><capsule/></geometry></visual><visual/><collision/><collision/>"
      "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
      "izz='1'/></inertial></link>"
      "<gazebo reference='a'><limits>${x}</limits></gazebo><sensor:camera/><frame link='a' name='f'/>"
      "<transmission name='t'><joint name='j'/></transmission><!-- <joint> --></robot><!-- late -->\n");
  EXPECT_EQ(m.links, std::vector<std::string>{"a"});
  EXPECT_TRUE(m.joints.empty());
}

TEST(ReadUrdf, ReadsJointsBeforeLinksAndTagsInAnyOrder) {
  const RobotModel m =
      read("<robot name='r'><joint type='revolute' name='j'>" + limit +
           "<!-- here --><axis xyz='0\t0\n 1  '/><child\n link='b'/>text<parent link='a'/></joint>"
           "<link name='b'></link><link name='a'/></robot>");
  EXPECT_EQ(m.joints[0].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(m.joints[0].parent, "a");
}

TEST(ReadUrdf, KeepsUnusualNames) {
  const std::string odd[] = {"wam/base_yaw",
                             "a &amp; b &lt;&quot;&apos;&gt;",
                             "\xC3\xA9\xE5\x85\xB3\xF0\x9F\xA4\x96",
                             " x  y ",
                             "%s\\n",
                             "&#9;t&#10;"};
  const std::string plain[] = {"wam/base_yaw", "a & b <\"'>", "\xC3\xA9\xE5\x85\xB3\xF0\x9F\xA4\x96",
                               " x  y ",       "%s\\n",       "\tt\n"};
  for (std::size_t i = 0; i < std::size(odd); ++i) {
    const std::string& n = odd[i];
    const RobotModel m =
        read("<robot name=\"" + n + "\"><link name=\"" + n + "\"/><link name=\"b\"/><joint name=\"" + n +
             "\" type=\"fixed\"><parent link=\"" + n + "\"/><child link=\"b\"/></joint></robot>");
    EXPECT_EQ(m.name, plain[i]);
    EXPECT_EQ(m.joints[0].name, plain[i]);
    EXPECT_EQ(m.joints[0].parent, plain[i]);
  }
}

/// A chain of `count` links, optionally closed to a loop.
std::string chain(int count, bool loop) {
  std::string text = "<robot name='r'>";
  for (int i = 0; i < count; ++i) text += "<link name='l" + std::to_string(i) + "'/>";
  for (int i = 0; i + 1 < count; ++i)
    text += joint("j" + std::to_string(i), "continuous", "l" + std::to_string(i), "l" + std::to_string(i + 1),
                  i > 0 ? "<mimic joint='j" + std::to_string(i - 1) + "'/>" : "");
  if (loop) text += joint("j", "fixed", "l" + std::to_string(count - 1), "l0", "");
  return text + "</robot>";
}

TEST(ReadUrdf, ReadsTensOfThousandsOfLinksQuickly) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read(chain(10000, false)).joints.size(), 9999u);
  EXPECT_NE(refusal(chain(10000, true)).find("form a loop"), std::string::npos);
  std::string alone = "<robot name='r'>";
  for (int i = 0; i < 30000; ++i) alone += "<link name='l" + std::to_string(i) + "'/>";
  EXPECT_NE(refusal(alone + "</robot>").find("30000 roots"), std::string::npos);
  std::string misspelt = "<robot name='r'>";
  for (int i = 0; i < 10000; ++i) misspelt += joint("j" + std::to_string(i), "fixed", "x", "y");
  EXPECT_NE(refusal(misspelt + links + "</robot>").find("not a link"), std::string::npos);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(spent.count(), 7.0);  // quadratic work would take longer
}

struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(ReadUrdf, ReadsTheSameInEveryLocale) {
  const std::string text = inside_joint("<origin xyz='1234.5678 0.001 1e-7'/><axis xyz='0 0 2000'/>" + limit);
  const RobotModel before = read(text);
  const std::locale previous = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const RobotModel after = read(text);
  std::locale::global(previous);
  EXPECT_EQ(before.joints[0].origin.matrix(), after.joints[0].origin.matrix());
  EXPECT_EQ(after.joints[0].origin.translation(), Eigen::Vector3d(1234.5678, 0.001, 1e-7));
  EXPECT_EQ(warnings(before), warnings(after));
}

const std::filesystem::path robots = std::filesystem::path(QERR_SOURCE_DIR) / "../shared/robots";

TEST(ReadUrdf, ReadsRealRobots) {
  if (!std::filesystem::exists(robots)) GTEST_SKIP() << "no third-party robots at " << robots;
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(robots)) {
    if (entry.path().extension() != ".urdf" || entry.path().filename() == "dup_link_r2_gripper.urdf")
      continue;
    ++count;
    try {
      EXPECT_FALSE(read_urdf(entry.path().string()).joints.empty()) << entry.path();
    } catch (const Error& e) {
      ADD_FAILURE() << e.what();
    }
  }
  EXPECT_GT(count, 10);
}

TEST(ReadUrdf, ReadsDefectiveRobotsAsDocumented) {
  const auto nasty = [](const char* name) { return (robots / "nasty" / name).string(); };
  if (!std::filesystem::exists(nasty("drake_iiwa_no_limits.urdf")))
    GTEST_SKIP() << "no nasty robots at " << robots;
  const RobotModel iiwa = read_urdf(nasty("drake_iiwa_no_limits.urdf"));
  EXPECT_EQ(warnings(iiwa).size(), 7u);
  for (const auto& j : iiwa.joints) EXPECT_FALSE(j.limits);
  for (const auto& j : read_urdf(nasty("minitaur.urdf")).joints) EXPECT_FALSE(j.limits) << j.name;
  EXPECT_EQ(warnings(read_urdf(nasty("bullet_humanoid_axes.urdf"))).size(),
            9u);  // 8 axes and an empty name
  int zero_ranges = 0;
  for (const auto& j : read_urdf(nasty("zero_range_simple_humanoid.urdf")).joints)
    zero_ranges += j.limits && j.limits->lower == 0 && j.limits->upper == 0;
  EXPECT_EQ(zero_ranges, 29);
  const RobotModel romeo = read_urdf(nasty("romeo_skew_axes.urdf"));
  int mimics = 0;
  for (const auto& j : romeo.joints) mimics += j.mimic.has_value();
  EXPECT_EQ(mimics, 22);
  const RobotModel gripper = read_urdf(nasty("dup_link_r2_gripper.urdf"));
  ASSERT_FALSE(flaws(gripper, true).empty());
  EXPECT_NE(format(flaws(gripper, true)).find("'r2/left_leg/ati': duplicate name of a link"),
            std::string::npos);
}

}  // namespace
}  // namespace qerr
