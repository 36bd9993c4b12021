#include "qerr/input/read_urdf.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <locale>
#include <numbers>

#include "input/read_text.hpp"
#include "qerr/core/error.hpp"

namespace {

using qerr::Error;
using qerr::JointType;
using qerr::RobotModel;

const std::string limit = R"(<limit lower="-1" upper="2" effort="3" velocity="4"/>)";
const std::string links = R"(<link name="a"/><link name="b"/><link name="c"/>)";

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside = limit) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" +
         child + "'/>" + inside + "</joint>";
}

/// A robot whose line 2 holds `body`.
std::string robot(const std::string& body) { return "<robot name='r'>\n" + body + "\n</robot>\n"; }

/// Links a, b, c in a row; the first joint is revolute and has `inside` on line 3.
std::string inside_joint(const std::string& inside, const std::string& type = "revolute") {
  return robot(links + joint("ab", type, "a", "b", "\n" + inside + "\n") +
               joint("bc", "fixed", "b", "c", ""));
}

RobotModel read(const std::string& text) { return qerr::parse_urdf(text, "r.urdf"); }

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), qerr::Trouble::input);
    return e.what();
  }
  return "accepted";
}

TEST(Urdf, ReadsATreeWithEveryJointType) {
  const RobotModel m = read(
      robot("<link name='w'/>" + links + "<link name='d'/><link name='e'/><link name='f'/>" +
            joint("1", "revolute", "w", "a") + joint("2", "continuous", "a", "b", "") +
            joint("3", "prismatic", "b", "c") + joint("4", "fixed", "c", "d", "<axis xyz='0 0 0'/>") +
            joint("5", "floating", "c", "e", "") + joint("6", "planar", "c", "f", "<axis xyz='0 0 1'/>")));
  EXPECT_EQ(m.name, "r");
  EXPECT_EQ(m.file, "r.urdf");
  EXPECT_EQ(m.links, (std::vector<std::string>{"w", "a", "b", "c", "d", "e", "f"}));
  ASSERT_EQ(m.joints.size(), 6u);
  const JointType types[] = {JointType::revolute, JointType::continuous, JointType::prismatic,
                             JointType::fixed,    JointType::floating,   JointType::planar};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(m.joints[i].type, types[i]);
  EXPECT_EQ(m.joints[2].parent, "b");
  EXPECT_EQ(m.joints[2].child, "c");
  EXPECT_EQ(m.joints[0].limits->lower, -1);
  EXPECT_EQ(m.joints[0].limits->upper, 2);
  EXPECT_FALSE(m.joints[1].limits);
  EXPECT_EQ(m.joints[0].axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(m.joints[5].axis, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(m.warnings.empty());
}

TEST(Urdf, GivesThePlaceOfEachJoint) {
  const RobotModel m =
      read(robot(links + joint("x", "fixed", "a", "b", "") + "\n\n  " + joint("y", "fixed", "b", "c")));
  EXPECT_EQ(m.joints[0].place.line, 2);
  EXPECT_EQ(m.joints[0].place.column, static_cast<int>(links.size()) + 1);
  EXPECT_EQ(m.joints[1].place.line, 4);
  EXPECT_EQ(m.joints[1].place.column, 3);
  EXPECT_EQ(m.joints[1].place.file, "r.urdf");
}

TEST(Urdf, RotatesByRollPitchYawToFullPrecision) {
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

TEST(Urdf, ReadsMimicWithItsDefaults) {
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

TEST(Urdf, NormalisesAnAxisAndSaysSo) {
  const RobotModel m = read(inside_joint("<axis xyz='0 1 1'/>", "continuous"));
  EXPECT_NEAR(m.joints[0].axis.y(), std::sqrt(0.5), 3e-16);
  EXPECT_NEAR(m.joints[0].axis.norm(), 1, 1e-15);
  ASSERT_EQ(m.warnings.size(), 1u);
  EXPECT_NE(m.warnings[0].find("r.urdf:3:1: joint 'ab': the axis '0 1 1' has norm 1.414"), std::string::npos);
  const RobotModel huge = read(inside_joint("<axis xyz='0 1e300 1e300'/>", "continuous"));
  EXPECT_NEAR(huge.joints[0].axis.y(), std::sqrt(0.5), 1e-15);
}

TEST(Urdf, TakesPrintedDecimalsAsUnitLength) {
  const RobotModel m = read(inside_joint("<axis xyz='0 0.7071067 0.7071068'/>", "continuous"));
  EXPECT_TRUE(m.warnings.empty());
  EXPECT_NEAR(m.joints[0].axis.norm(), 1, 1e-15);
}

TEST(Urdf, LeavesLimitsEmptyWhereNoneAreGiven) {
  const RobotModel without = read(inside_joint(""));
  EXPECT_FALSE(without.joints[0].limits);
  ASSERT_EQ(without.warnings.size(), 1u);
  EXPECT_NE(without.warnings[0].find("joint 'ab': a revolute joint should have a <limit>"),
            std::string::npos);
  const RobotModel effort_only = read(inside_joint("<limit effort='1' velocity='1'/>"));
  EXPECT_FALSE(effort_only.joints[0].limits);
  EXPECT_TRUE(effort_only.warnings.empty());
  EXPECT_FALSE(read(inside_joint(limit, "continuous")).joints[0].limits);
  const RobotModel half = read(inside_joint("<limit upper='2' effort='1' velocity='1'/>"));
  EXPECT_EQ(half.joints[0].limits->lower, 0);
  EXPECT_EQ(half.joints[0].limits->upper, 2);
}

TEST(Urdf, WarnsOfAMimicThatMeansNothing) {
  const RobotModel fixed = read(inside_joint("<mimic joint='nobody'/>", "fixed"));
  EXPECT_FALSE(fixed.joints[0].mimic);
  EXPECT_EQ(fixed.warnings.size(), 1u);
  const RobotModel zero =
      read(robot(links + joint("ab", "continuous", "a", "b", "<mimic joint='bc' multiplier='0'/>") +
                 joint("bc", "continuous", "b", "c", "")));
  EXPECT_EQ(zero.joints[0].mimic->multiplier, 0);
  EXPECT_EQ(zero.warnings.size(), 1u);
}

TEST(Urdf, ReadsARobotWhoseNameIsEmptyWithAWarning) {
  const RobotModel m = read("<robot name=''><link name='a'/></robot>");
  EXPECT_EQ(m.name, "");
  EXPECT_EQ(m.warnings.size(), 1u);
}

TEST(Urdf, LeavesOutWhatIsNotKinematics) {
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

TEST(Urdf, ReadsJointsBeforeLinksAndTagsInAnyOrder) {
  const RobotModel m =
      read("<robot name='r'><joint type='revolute' name='j'>" + limit +
           "<!-- here --><axis xyz='0\t0\n 1  '/><child\n link='b'/>text<parent link='a'/></joint>"
           "<link name='b'></link><link name='a'/></robot>");
  EXPECT_EQ(m.joints[0].axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(m.joints[0].parent, "a");
}

TEST(Urdf, KeepsUnusualNames) {
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

struct Bad {
  const char* what;
  std::string text;
  int line;
  const char* message;
};

std::vector<Bad> bad_documents() {
  const std::string two = links + joint("bc", "fixed", "b", "c", "");
  const std::string deep = [] {
    std::string text = "<robot name='r'>\n";
    for (int i = 0; i < 300; ++i) text += "<x>";
    return text;
  }();
  const std::string wide = [] {
    std::string text = "<robot name='r'>\n<link";
    for (int i = 0; i < 1001; ++i) text += " a" + std::to_string(i) + "='1'";
    return text + "/></robot>";
  }();
  const auto mimics = [](const std::string& first, const std::string& second,
                         const std::string& type = "continuous") {
    return robot(links + joint("ab", "continuous", "a", "b", "\n" + first) +
                 joint("bc", type, "b", "c", second));
  };
  return {
      {"empty", "", 1, "the document is empty"},
      {"blank", "\n \n", 3, "the document is empty"},
      {"no XML", "robot: r\n", 1, "malformed"},
      {"unclosed", "<robot name='r'>\n<link name='a'>\n", 3, "<link> of line 2 is still open"},
      {"wrong closing tag", "<robot name='r'>\n<link name='a'>\n</joint></robot>", 3,
       "<link> of line 2 is still open"},
      {"second root", "<robot name='r'><link name='a'/></robot>\n<robot/>", 2, "nothing may follow </robot>"},
      {"text after the root", "<robot name='r'><link name='a'/></robot>\nx", 2, "nothing may follow"},
      {"late declaration", "\n<?xml version='1.0'?><robot/>", 2, "must be the very first"},
      {"same attribute twice", "<robot name='r'>\n<link name='a' name='b'/></robot>", 2,
       "duplicate attribute"},
      {"unquoted value", "<robot name='r'>\n<link name=a/></robot>", 2, "malformed"},
      {"undefined entity", "<robot name='r'>\n<link name='&x;'/></robot>", 2, "undefined entity"},
      {"DTD", "\n<!DOCTYPE robot [<!ENTITY a 'b'>]><robot/>", 2, "DTD"},
      {"too deep", deep, 2, "more than 256 deep"},
      {"too many attributes", wide, 2, "more than 1000 attributes"},
      {"cut in UTF-8", "<robot name='r'>\n\xF0", 2, "byte 0xF0"},
      {"NUL", std::string("<robot name='r'>\n\0</robot>", 26), 2, "NUL"},
      {"SDF", "<?xml version='1.0'?>\n<sdf version='1.6'/>", 2, "SDF file, not a URDF"},
      {"another root", "<Robot name='r'/>", 1, "root element of a URDF is <robot>"},
      {"xacro element", robot("<xacro:include filename='x'/>"), 2, "expand it with xacro first"},
      {"xacro value", robot("<link name='${prefix}a'/>"), 2, "expand it with xacro first"},
      {"version", "<robot name='r' version='2.0'><link name='a'/></robot>", 1,
       "version of URDF is not known"},
      {"nameless robot", "<robot><link name='a'/></robot>", 1, "a robot must have a name"},
      {"no links", robot(""), 1, "at least one link"},
      {"nameless link", robot("<link/>"), 2, "a link must have a name"},
      {"same link twice", robot("<link name='a'/>\n<link name='a'/>"), 3,
       "link 'a': two links have this name"},
      {"misspelt link", robot("<lnik name='a'/>"), 2, "did you mean <link>?"},
      {"misspelt joint", robot(links + "<Joint name='x'/>"), 2, "did you mean <joint>?"},
      {"mass with a unit", robot("<link name='a'><inertial>\n<mass value='3.5kg'/></inertial></link>"), 3,
       "'3.5kg'"},
      {"negative mass", robot("<link name='a'><inertial>\n<mass value='-1'/></inertial></link>"), 3,
       "negative"},
      {"inertia", robot("<link name='a'><inertial>\n<inertia ixx='x'/></inertial></link>"), 3,
       "'ixx' of <inertia>"},
      {"misspelt inertial", robot("<link name='a'>\n<inertia ixx='1'/></link>"), 3,
       "did you mean <inertial>?"},
      {"same joint twice", robot(two + "\n" + joint("bc", "fixed", "a", "b", "")), 3,
       "two joints have this name"},
      {"nameless joint", robot(two + "\n<joint type='fixed'/>"), 3, "a joint must have a name"},
      {"no type", robot(two + "\n<joint name='j'><parent link='a'/><child link='b'/></joint>"), 3,
       "must have a type"},
      {"capital type", robot(two + "\n" + joint("ab", "Revolute", "a", "b")), 3, "did you mean 'revolute'?"},
      {"strange type", robot(two + "\n" + joint("ab", "hydraulic", "a", "b")), 3, "known: continuous, fixed"},
      {"no parent", robot(two + "\n<joint name='j' type='fixed'><child link='b'/></joint>"), 3,
       "must have a <parent>"},
      {"no child", robot(two + "\n<joint name='j' type='fixed'><parent link='b'/></joint>"), 3,
       "must have a <child>"},
      {"no link", robot(two + "\n<joint name='j' type='fixed'><parent/><child link='b'/></joint>"), 3,
       "must have 'link'"},
      {"empty child", robot(two + "\n" + joint("ab", "fixed", "a", "", "")), 3, "must not be empty"},
      {"unknown parent",
       robot("<link name='base'/><link name='b'/>\n" + joint("j", "fixed", "bsae", "b", "")), 3,
       "did you mean 'base'?"},
      {"unknown child", robot(two + "\n" + joint("ab", "fixed", "a", "nobody", "")), 3,
       "'nobody'; known: a, b, c"},
      {"joint to itself", robot(two + "\n" + joint("ab", "fixed", "a", "a", "")), 3,
       "parent and child must be two"},
      {"two parents", robot(two + "\n" + joint("ac", "fixed", "a", "c", "")), 3,
       "already the child of joint 'bc'"},
      {"loop of all",
       robot(two + joint("ab", "fixed", "a", "b", "") + "\n" + joint("ca", "fixed", "c", "a", "")), 3,
       "form a loop"},
      {"loop beside the tree", robot(two + "\n" + joint("cb", "fixed", "c", "b", "")), 3,
       "'b' under 'c' under 'b'"},
      {"two roots", robot("<link name='a'/>\n<link name='b'/>"), 3, "one root link, found 2 roots: 'a', 'b'"},
      {"misspelt origin", inside_joint("<orign xyz='1 0 0'/>" + limit), 3, "did you mean <origin>?"},
      {"misspelt limit", inside_joint("<limits lower='1'/>"), 3, "did you mean <limit>?"},
      {"misspelt axis", inside_joint("<axes xyz='1 0 0'/>"), 3, "did you mean <axis>?"},
      {"misspelt lower", inside_joint("<limit lowr='1' effort='1' velocity='1'/>"), 3,
       "did you mean 'lower'?"},
      {"misspelt xyz", inside_joint("<origin xy='1 0 0'/>"), 3, "did you mean 'xyz'?"},
      {"quaternion", inside_joint("<origin quat_xyzw='0 0 0 1'/>"), 3, "quaternion"},
      {"two axes", inside_joint("<axis xyz='1 0 0'/><axis xyz='0 0 1'/>"), 3, "<axis> is given twice"},
      {"two limits", inside_joint(limit + "\n" + limit), 4, "<limit> is given twice"},
      {"two parents given", inside_joint("<parent link='c'/>"), 3, "<parent> is given twice"},
      {"zero axis", inside_joint("<axis xyz='0 0 0'/>" + limit), 3, "must not be zero"},
      {"empty axis", inside_joint("<axis/>" + limit), 3, "<axis> must have 'xyz'"},
      {"two numbers", inside_joint("<axis xyz='0 1'/>" + limit), 3, "must be 3 finite numbers, found '0 1'"},
      {"four numbers", inside_joint("<origin rpy='0 1 2 3'/>" + limit), 3, "must be 3 finite numbers"},
      {"no numbers", inside_joint("<origin xyz=''/>" + limit), 3, "must be 3 finite numbers"},
      {"decimal comma", inside_joint("<origin xyz='0,5 0 0'/>" + limit), 3, "write decimals with a point"},
      {"nan", inside_joint("<origin xyz='nan 0 0'/>" + limit), 3, "finite"},
      {"infinite", inside_joint("<origin xyz='0 inf 0'/>" + limit), 3, "finite"},
      {"overflow", inside_joint("<origin xyz='0 1e400 0'/>" + limit), 3, "finite"},
      {"hexadecimal", inside_joint("<origin xyz='0x10 0 0'/>" + limit), 3, "finite"},
      {"limit text", inside_joint("<limit lower='-pi' effort='1' velocity='1'/>"), 3, "'-pi'"},
      {"no effort", inside_joint("<limit lower='0' upper='1' velocity='1'/>"), 3, "must have 'effort'"},
      {"no velocity", inside_joint("<limit lower='0' upper='1' effort='1'/>"), 3, "must have 'velocity'"},
      {"negative velocity", inside_joint("<limit effort='1' velocity='-1'/>"), 3, "must not be negative"},
      {"swapped limits", inside_joint("<limit lower='1' upper='-1' effort='1' velocity='1'/>"), 3,
       "look swapped"},
      {"lower above 0", inside_joint("<limit lower='1' effort='1' velocity='1'/>"), 3,
       "upper 0 (the default)"},
      {"mimic nothing", mimics("<mimic/>", ""), 3, "<mimic> must have 'joint'"},
      {"mimic unknown", mimics("<mimic joint='bd'/>", ""), 3,
       "not one of this robot, found 'bd'; did you mean"},
      {"mimic itself", mimics("<mimic joint='ab'/>", ""), 3, "cannot mimic itself"},
      {"mimic loop", mimics("<mimic joint='bc'/>", "<mimic joint='ab'/>"), 3, "'ab' mimics 'bc' mimics 'ab'"},
      {"mimic fixed", mimics("<mimic joint='bc'/>", "", "fixed"), 3, "'bc', which is fixed"},
      {"mimic multiplier", mimics("<mimic joint='bc' multiplier='two'/>", ""), 3, "'multiplier' of <mimic>"},
      {"floating mimic", inside_joint("<mimic joint='bc'/>", "floating"), 3, "a floating joint cannot mimic"},
  };
}

TEST(Urdf, RefusesBadDocumentsAtTheirLine) {
  for (const Bad& bad : bad_documents()) {
    const std::string said = refusal(bad.text);
    EXPECT_NE(said.find(bad.message), std::string::npos) << bad.what << ": " << said;
    const std::string first = "r.urdf:" + std::to_string(bad.line) + ":";
    EXPECT_NE(said.find(first), std::string::npos) << bad.what << ": " << said;
  }
}

TEST(Urdf, NamesTheColumnOfTheAttribute) {
  const std::string said =
      refusal(robot("<link name='a'/><link name='b'/>\n <joint name='j' \t type='fixed'>\n"
                    "  <parent link='a'/>\n  <child  link='\xC3\xA9'/>\n</joint>"));
  EXPECT_EQ(said.find("r.urdf:5:11: joint 'j': "), 0u) << said;
}

TEST(Urdf, ReportsIndependentFaultsTogether) {
  try {
    read(inside_joint("<axis xyz='0 0 0'/>\n<limit lower='1' upper='0' effort='-1' velocity='1'/>"));
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.faults().size(), 3u);
    EXPECT_EQ(e.faults()[0].place.line, 3);
    EXPECT_EQ(e.faults()[1].place.line, 4);
    EXPECT_EQ(e.faults()[0].key, "joint 'ab'");
  }
}

TEST(Urdf, SurvivesEveryCutAndMostBytes) {
  const std::string whole = inside_joint("<origin xyz='1 2 3' rpy='0 0 0'/>" + limit + "<axis xyz='0 0 1'/>");
  for (std::size_t i = 0; i + 2 < whole.size(); ++i) EXPECT_THROW(read(whole.substr(0, i)), Error) << i;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char c : {'\0', '<', '>', '"', '\'', '&', ' ', '/', '9', '\xF0'}) {
      std::string changed = whole;
      changed[i] = c;
      try {
        read(changed);
      } catch (const Error&) {
      }
    }
  }
}

/// `count` links in a row, closed to a loop when asked.
std::string chain(int count, bool loop) {
  std::string text = "<robot name='r'>";
  for (int i = 0; i < count; ++i) text += "<link name='l" + std::to_string(i) + "'/>";
  for (int i = 0; i + 1 < count; ++i)
    text += joint("j" + std::to_string(i), "continuous", "l" + std::to_string(i), "l" + std::to_string(i + 1),
                  i > 0 ? "<mimic joint='j" + std::to_string(i - 1) + "'/>" : "");
  if (loop) text += joint("j", "fixed", "l" + std::to_string(count - 1), "l0", "");
  return text + "</robot>";
}

TEST(Urdf, ReadsTensOfThousandsOfLinksQuickly) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read(chain(30000, false)).joints.size(), 29999u);
  EXPECT_NE(refusal(chain(30000, true)).find("form a loop"), std::string::npos);
  std::string alone = "<robot name='r'>";
  for (int i = 0; i < 100000; ++i) alone += "<link name='l" + std::to_string(i) + "'/>";
  EXPECT_NE(refusal(alone + "</robot>").find("100000 roots"), std::string::npos);
  std::string misspelt = "<robot name='r'>";
  for (int i = 0; i < 30000; ++i) misspelt += joint("j" + std::to_string(i), "fixed", "x", "y");
  EXPECT_NE(refusal(misspelt + links + "</robot>").find("not a link"), std::string::npos);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(spent.count(), 20.0);  // quadratic work would take minutes
}

struct Comma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Urdf, ReadsTheSameInEveryLocale) {
  const std::string text = inside_joint("<origin xyz='1234.5678 0.001 1e-7'/><axis xyz='0 0 2000'/>" + limit);
  const RobotModel before = read(text);
  const std::locale previous = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const RobotModel after = read(text);
  std::locale::global(previous);
  EXPECT_EQ(before.joints[0].origin.matrix(), after.joints[0].origin.matrix());
  EXPECT_EQ(after.joints[0].origin.translation(), Eigen::Vector3d(1234.5678, 0.001, 1e-7));
  EXPECT_EQ(before.warnings, after.warnings);
}

const std::filesystem::path robots = std::filesystem::path(QERR_SOURCE_DIR) / "../shared/robots";

TEST(Urdf, ReadsRealRobots) {
  if (!std::filesystem::exists(robots)) GTEST_SKIP() << "no third-party robots at " << robots;
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(robots)) {
    if (entry.path().extension() != ".urdf" || entry.path().filename() == "dup_link_r2_gripper.urdf")
      continue;
    ++count;
    try {
      EXPECT_FALSE(qerr::read_urdf(entry.path().string()).joints.empty()) << entry.path();
    } catch (const Error& e) {
      ADD_FAILURE() << e.what();
    }
  }
  EXPECT_GT(count, 10);
}

TEST(Urdf, TreatsTheNastyRobotsAsTheirNotesSay) {
  const auto nasty = [](const char* name) { return (robots / "nasty" / name).string(); };
  if (!std::filesystem::exists(nasty("drake_iiwa_no_limits.urdf")))
    GTEST_SKIP() << "no nasty robots at " << robots;
  const RobotModel iiwa = qerr::read_urdf(nasty("drake_iiwa_no_limits.urdf"));
  EXPECT_EQ(iiwa.warnings.size(), 7u);
  for (const auto& j : iiwa.joints) EXPECT_FALSE(j.limits);
  for (const auto& j : qerr::read_urdf(nasty("minitaur.urdf")).joints) EXPECT_FALSE(j.limits) << j.name;
  EXPECT_EQ(qerr::read_urdf(nasty("bullet_humanoid_axes.urdf")).warnings.size(),
            9u);  // 8 axes and an empty name
  int zero_ranges = 0;
  for (const auto& j : qerr::read_urdf(nasty("zero_range_simple_humanoid.urdf")).joints)
    zero_ranges += j.limits && j.limits->lower == 0 && j.limits->upper == 0;
  EXPECT_EQ(zero_ranges, 29);
  const RobotModel romeo = qerr::read_urdf(nasty("romeo_skew_axes.urdf"));
  int mimics = 0;
  for (const auto& j : romeo.joints) mimics += j.mimic.has_value();
  EXPECT_EQ(mimics, 22);
  EXPECT_THROW(
      {
        try {
          qerr::read_urdf(nasty("dup_link_r2_gripper.urdf"));
        } catch (const Error& e) {
          EXPECT_NE(std::string(e.what()).find("'r2/left_leg/ati': two links have this name"),
                    std::string::npos);
          throw;
        }
      },
      Error);
}

TEST(ReadText, RefusesWhatIsNotAReadableFile) {
  for (const std::string path : {"/", "/nonexistent/r.urdf", "/dev/null", ""}) {
    try {
      qerr::read_text(path);
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), qerr::Trouble::file_system) << e.what();
    }
  }
}

TEST(ReadText, DropsAByteOrderMarkAndRefusesBadBytesAndHugeFiles) {
  const auto path =
      std::filesystem::temp_directory_path() / ("qerr_read_text_" + std::to_string(std::rand()));
  const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
  write("\xEF\xBB\xBFhello\n");
  EXPECT_EQ(qerr::read_text(path.string()), "hello\n");
  write("");
  EXPECT_EQ(qerr::read_text(path.string()), "");
  write("one\n\xC3\xA9\xC3(");
  try {
    qerr::read_text(path.string());
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), qerr::Trouble::input);
    EXPECT_EQ(e.faults()[0].place.line, 2);
    EXPECT_EQ(e.faults()[0].place.column, 2);
  }
  write(std::string(16'000'001, 'x'));
  EXPECT_THROW(qerr::read_text(path.string()), Error);
  std::filesystem::remove(path);
}

}  // namespace
