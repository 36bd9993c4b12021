#include <gtest/gtest.h>

#include <string>

#include "support/urdf_text.hpp"

namespace qerr {
namespace {

using namespace testing::urdf;

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
      {"no XML", "robot: r\n", 1, "this is not a URDF"},
      {"unclosed", "<robot name='r'>\n<link name='a'>\n", 3, "<link> of line 2 is still open"},
      {"wrong closing tag", "<robot name='r'>\n<link name='a'>\n</joint></robot>", 3,
       "<link> of line 2 is still open"},
      {"second root", "<robot name='r'><link name='a'/></robot>\n<robot/>", 2, "nothing may follow </robot>"},
      {"text after the root", "<robot name='r'><link name='a'/></robot>\nx", 2, "nothing may follow"},
      {"late declaration", "\n<?xml version='1.0'?><robot/>", 2, "must be at the start"},
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
      {"xacro element", robot("<xacro:include filename='x'/>"), 2, "install xacro"},
      {"xacro value", robot("<link name='${prefix}a'/>"), 2, "install xacro"},
      {"version", "<robot name='r' version='2.0'><link name='a'/></robot>", 1, "unknown version of URDF"},
      {"no links", robot(""), 1, "at least one link"},
      {"nameless link", robot("<link/>"), 2, "a link must have a name"},
      {"same link twice", robot("<link name='a'/>\n<link name='a'/>"), 3,
       "link 'a': duplicate name of a link"},
      {"misspelt link", robot("<lnik name='a'/>"), 2, "did you mean <link>?"},
      {"misspelt joint", robot(links + "<Joint name='x'/>"), 2, "did you mean <joint>?"},
      {"mass with a unit", robot("<link name='a'><inertial>\n<mass value='3.5kg'/></inertial></link>"), 3,
       "'3.5kg'"},
      {"negative mass", robot("<link name='a'><inertial>\n<mass value='-1'/></inertial></link>"), 3,
       "negative"},
      {"inertia", robot("<link name='a'><inertial>\n<inertia ixx='x'/></inertial></link>"), 3,
       "'ixx' of <inertia>"},
      {"same joint twice", robot(two + "\n" + joint("bc", "fixed", "a", "b", "")), 3,
       "duplicate name of a joint"},
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
       "parent and child must be different"},
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
      {"two axes", inside_joint("<axis xyz='1 0 0'/><axis xyz='0 0 1'/>"), 3, "duplicate <axis>"},
      {"two limits", inside_joint(limit + "\n" + limit), 4, "duplicate <limit>"},
      {"two parents given", inside_joint("<parent link='c'/>"), 3, "duplicate <parent>"},
      {"zero axis", inside_joint("<axis xyz='0 0 0'/>" + limit), 3, "must not be zero"},
      {"empty axis", inside_joint("<axis/>" + limit), 3, "<axis> must have 'xyz'"},
      {"two numbers", inside_joint("<axis xyz='0 1'/>" + limit), 3, "must be 3 finite numbers, found '0 1'"},
      {"four numbers", inside_joint("<origin rpy='0 1 2 3'/>" + limit), 3, "must be 3 finite numbers"},
      {"no numbers", inside_joint("<origin xyz=''/>" + limit), 3, "must be 3 finite numbers"},
      {"decimal comma", inside_joint("<origin xyz='0,5 0 0'/>" + limit), 3, "use a decimal point"},
      {"nan", inside_joint("<origin xyz='nan 0 0'/>" + limit), 3, "finite"},
      {"infinite", inside_joint("<origin xyz='0 inf 0'/>" + limit), 3, "finite"},
      {"overflow", inside_joint("<origin xyz='0 1e400 0'/>" + limit), 3, "finite"},
      {"hexadecimal", inside_joint("<origin xyz='0x10 0 0'/>" + limit), 3, "finite"},
      {"limit text", inside_joint("<limit lower='-pi' effort='1' velocity='1'/>"), 3, "'-pi'"},
      {"swapped limits", inside_joint("<limit lower='1' upper='-1' effort='1' velocity='1'/>"), 3,
       "exchange them"},
      {"lower above 0", inside_joint("<limit lower='1' effort='1' velocity='1'/>"), 3,
       "upper 0 (the default)"},
      {"mimic nothing", mimics("<mimic/>", ""), 3, "<mimic> must have 'joint'"},
      {"mimic unknown", mimics("<mimic joint='bd'/>", ""), 3,
       "unknown joint to mimic, found 'bd'; did you mean"},
      {"mimic itself", mimics("<mimic joint='ab'/>", ""), 3, "cannot mimic itself"},
      {"mimic loop", mimics("<mimic joint='bc'/>", "<mimic joint='ab'/>"), 3, "'ab' mimics 'bc' mimics 'ab'"},
      {"mimic fixed", mimics("<mimic joint='bc'/>", "", "fixed"), 3, "'bc', which is fixed"},
      {"mimic multiplier", mimics("<mimic joint='bc' multiplier='two'/>", ""), 3, "'multiplier' of <mimic>"},
      {"floating mimic", inside_joint("<mimic joint='bc'/>", "floating"), 3, "a floating joint cannot mimic"},
  };
}

TEST(UrdfErrors, AreReportedAtTheirLine) {
  for (const Bad& bad : bad_documents()) {
    const std::string said = refusal(bad.text);
    EXPECT_NE(said.find(bad.message), std::string::npos) << bad.what << ": " << said;
    const std::string first = "r.urdf:" + std::to_string(bad.line) + ":";
    EXPECT_NE(said.find(first), std::string::npos) << bad.what << ": " << said;
  }
}

TEST(UrdfErrors, AreReportedAtTheColumnOfTheAttribute) {
  const std::string said =
      refusal(robot("<link name='a'/><link name='b'/>\n <joint name='j' \t type='fixed'>\n"
                    "  <parent link='a'/>\n  <child  link='\xC3\xA9'/>\n</joint>"));
  EXPECT_EQ(said.find("r.urdf:5:11: joint 'j': "), 0u) << said;
}

TEST(UrdfErrors, AreReportedTogetherIfIndependent) {
  try {
    read_strictly(inside_joint("<axis xyz='0 0 0'/>\n<limit lower='1' upper='0' effort='1' velocity='1'/>"));
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.faults().size(), 2u);
    EXPECT_EQ(e.faults()[0].place.line, 3);
    EXPECT_EQ(e.faults()[1].place.line, 4);
    EXPECT_EQ(e.faults()[0].key, "joint 'ab'");
  }
}

TEST(UrdfErrors, AreReportedForEveryTruncationAndReplacedByte) {
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

}  // namespace
}  // namespace qerr
