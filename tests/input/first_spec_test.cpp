#include "qerr/input/first_spec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "support/urdf_text.hpp"

namespace qerr {
namespace {

using namespace testing::urdf;

/// A folder with robot.urdf, whose first spec is read as a user would read it.
class FirstSpec : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_first_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string text_of(const std::string& urdf, const std::string& base = "", const std::string& tip = "") {
    std::ofstream(folder_ / "robot.urdf") << urdf;
    const RobotModel robot = read(urdf);
    return first_spec(robot, first_chain(robot, base, tip), "robot.urdf");
  }

  Spec spec_of(const std::string& urdf, const std::string& base = "", const std::string& tip = "") {
    return parse_spec(text_of(urdf, base, tip), (folder_ / "spec.yaml").string());
  }

  std::filesystem::path folder_;
};

std::string two_joints(const std::string& first, const std::string& second, const std::string& more = "",
                       const std::string& type = "revolute") {
  return robot(links + joint("ab", "revolute", "a", "b", "<origin xyz='1 0 0'/>" + first) +
               joint("bc", type, "b", "c", "<origin xyz='1 0 0'/><axis xyz='0 0 1'/>" + second) + more);
}

TEST_F(FirstSpec, IsReadAsItIs) {
  const Spec spec = spec_of(two_joints(limit, limit));
  EXPECT_EQ(spec.model.chain.base, "a");
  EXPECT_EQ(spec.model.chain.tip, "c");
  ASSERT_EQ(spec.model.transmission.encoders.size(), 2u);
  EXPECT_EQ(spec.configurations.ranges[0].lower, -1);
  EXPECT_EQ(spec.configurations.ranges[0].upper, 2);
  EXPECT_EQ(spec.filters.size(), 1u);
  EXPECT_TRUE(spec.warnings.empty());
}

TEST_F(FirstSpec, HasTheFewestEntriesThatSayIt) {
  const auto ratio = [](const std::string& name, const std::string& value) {
    return "<transmission name='t" + name + "'><joint name='" + name + "'/><mechanicalReduction>" + value +
           "</mechanicalReduction></transmission>";
  };
  const std::string third = "<link name='d'/>" + joint("cd", "revolute", "c", "d");
  const std::string urdf = two_joints(limit, limit, third + ratio("ab", "50") + ratio("bc", "50"));
  const std::string text = text_of(urdf);
  EXPECT_NE(text.find("  '*': {counts_per_rev: 4096, gear_ratio: 50}"), std::string::npos) << text;
  EXPECT_NE(text.find("  cd: {bits: 17, gear_ratio: 1}"), std::string::npos) << text;
  const Spec spec = spec_of(urdf);
  EXPECT_TRUE(spec.warnings.empty()) << spec.warnings.front();
  EXPECT_EQ(spec.model.transmission.encoders[1].shaft_ratio, 50);
  EXPECT_EQ(spec.model.transmission.encoders[2].shaft_ratio, 1);
  EXPECT_EQ(text_of(two_joints(limit, limit, ratio("ab", "50"))).find("'*'"), std::string::npos);
  // A motor that turns against its joint is no template's placeholder.
  const Spec against = spec_of(two_joints(limit, limit, ratio("ab", "-1")));
  EXPECT_EQ(against.model.transmission.encoders[0].shaft_ratio, -1);
  EXPECT_TRUE(against.warnings.empty()) << against.warnings.front();
}

TEST_F(FirstSpec, HasTheCouplingOfADifferential) {
  const std::string wrist =
      "<ros2_control name='c' type='system'><transmission name='t'>"
      "<plugin>transmission_interface/DifferentialTransmission</plugin>"
      "<actuator name='m1' role='actuator1'><mechanical_reduction>50</mechanical_reduction></actuator>"
      "<actuator name='m2' role='actuator2'><mechanical_reduction>-50</mechanical_reduction></actuator>"
      "<joint name='bc' role='joint1'/><joint name='cd' role='joint2'>"
      "<mechanical_reduction>2.0</mechanical_reduction></joint></transmission></ros2_control>";
  const std::string third = "<link name='d'/>" + joint("cd", "revolute", "c", "d");
  const Spec spec = spec_of(two_joints(limit, limit, third + wrist));
  const Transmission& t = spec.model.transmission;
  EXPECT_TRUE(spec.warnings.empty()) << spec.warnings.front();
  EXPECT_EQ(t.encoders[1].shaft_ratio, 50);
  EXPECT_EQ(t.encoders[2].shaft_ratio, -50);
  Eigen::Matrix3d wanted;
  wanted << 1, 0, 0, 0, 0.5, 0.5, 0, 0.25, -0.25;
  EXPECT_EQ(t.coupling.dense(), wanted);
}

TEST_F(FirstSpec, TakesAnImplausibleRatioOfASlideForThatOfItsGear) {
  const std::string screw =
      "<transmission name='t'><joint name='bc'/><mechanicalReduction>3</mechanicalReduction>"
      "</transmission>";
  const std::string text = text_of(two_joints(limit, limit, screw, "prismatic"));
  EXPECT_NE(text.find("bc: {counts_per_rev: 4096, gear_ratio: 3, travel_per_rev: 10 mm}"), std::string::npos)
      << text;
}

TEST_F(FirstSpec, StatesAnAssumptionForEachEncoderAndEachMissingRange) {
  const std::string text = text_of(two_joints("", "", "", "continuous"));
  for (const char* line : {"  '*': {bits: 17}  # ASSUMED", "# joints 'ab', 'bc'",
                           "    ab: [-180 deg, 180 deg]  # ASSUMED: the URDF has no limits",
                           "    bc: [-180 deg, 180 deg]  # ASSUMED: a continuous joint has no limits"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
  EXPECT_NEAR(spec_of(two_joints("", "")).configurations.ranges[1].upper, std::numbers::pi, 1e-12);
}

TEST_F(FirstSpec, TakesTheRatiosThatTheUrdfStates) {
  const std::string ratios =
      "<transmission name='t'><joint "
      "name='ab'/><mechanicalReduction>-101</mechanicalReduction></transmission>"
      "<transmission name='u'><joint "
      "name='bc'/><mechanicalReduction>-5000</mechanicalReduction></transmission>";
  const Spec spec = spec_of(two_joints(limit, limit, ratios, "prismatic"));
  EXPECT_NEAR(spec.model.transmission.encoders[0].shaft_ratio, -101, 1e-9);
  EXPECT_NEAR(spec.model.transmission.encoders[1].shaft_ratio, -5000, 1e-6);
  EXPECT_TRUE(spec.warnings.empty()) << spec.warnings.front();
}

TEST_F(FirstSpec, AssumesRangesWhereAllOfTheUrdfAreEmpty) {
  const std::string zero = "<limit lower='0' upper='0' effort='0' velocity='0'/>";
  EXPECT_NEAR(spec_of(two_joints(zero, zero)).configurations.ranges[0].lower, -std::numbers::pi, 1e-12);
  EXPECT_EQ(spec_of(two_joints(zero, limit)).configurations.ranges[0].upper, 0);
}

TEST_F(FirstSpec, ChoosesTheFirstEndThatCanBeUsed) {
  const std::string finger =
      "<link name='d'/>" + joint("cd", "revolute", "c", "d", "<axis xyz='0 0 0'/>" + limit);
  const std::string tool = "<link name='tool0'/>" + joint("ct", "fixed", "c", "tool0", "");
  EXPECT_EQ(spec_of(two_joints(limit, limit, finger + tool)).model.chain.tip, "tool0");
  EXPECT_EQ(spec_of(two_joints(limit, limit, tool), "b").model.chain.base, "b");
  EXPECT_EQ(spec_of(two_joints(limit, limit, tool), "", "b").model.chain.tip, "b");
}

TEST_F(FirstSpec, GivesTheAnglesOfATipThatDoesNotMove) {
  const Spec wheel =
      spec_of(robot(links + joint("ab", "fixed", "a", "b", "") + joint("bc", "continuous", "b", "c", "")));
  ASSERT_EQ(wheel.model.coordinates.size(), 3u);
  EXPECT_EQ(wheel.model.coordinates[0], Coordinate::rx);
}

TEST_F(FirstSpec, QuotesNamesThatYamlWouldReadOtherwise) {
  for (const std::string name : {"null", "12", "a: b", "x,y", "[j]", "wam/yaw", "#1", "~", " lead", "it's"}) {
    const std::string attribute = "\"" + name + "\"";
    const std::string urdf =
        "<robot name='r'><link name='a'/><link name=" + attribute + "/><joint name=" + attribute +
        " type='revolute'><parent link='a'/><child link=" + attribute + "/>" + limit + "</joint></robot>";
    const Spec spec = spec_of(urdf);
    EXPECT_EQ(spec.model.chain.tip, name);
    EXPECT_EQ(spec.model.chain.independent.at(0).name, name);
  }
}

TEST_F(FirstSpec, IsRefusedForARobotWithoutMotion) {
  const RobotModel table =
      read(robot(links + joint("ab", "fixed", "a", "b", "") + joint("bc", "fixed", "b", "c", "")));
  try {
    first_chain(table);
    FAIL() << "a chain was found";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no joint of this robot moves"), std::string::npos) << e.what();
  }
}

/// A spec by hand for robot.urdf.
class SpecOfAUrdf : public FirstSpec {
 protected:
  Spec spec_with(const std::string& urdf, const std::string& more) {
    std::ofstream(folder_ / "robot.urdf") << urdf;
    return parse_spec("qerr: 1\nrobot: {urdf: robot.urdf}\n" + more, (folder_ / "spec.yaml").string());
  }
  std::string refusal_of(const std::string& urdf, const std::string& more) {
    try {
      spec_with(urdf, more);
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

const std::string bits = "encoders: {'*': {bits: 17}}\n";

TEST_F(SpecOfAUrdf, WarnsOfARatioThatTheUrdfContradicts) {
  const auto warning = [&](const std::string& stated, const std::string& entry) {
    const Spec spec = spec_with(two_joints(limit, limit,
                                           "<transmission name='t'><joint name='ab'/><mechanicalReduction>" +
                                               stated + "</mechanicalReduction></transmission>"),
                                "encoders: {ab: {" + entry + "}, bc: {bits: 17}}\n");
    return spec.warnings.empty() ? "" : spec.warnings.front();
  };
  const std::string found = warning("101", "counts_per_rev: 4096, gear_ratio: 100");
  EXPECT_NE(found.find("'ab' 101 (spec: gear_ratio 100)"), std::string::npos) << found;
  EXPECT_NE(warning("-101", "counts_per_rev: 4096, gear_ratio: 101"), "");
  EXPECT_NE(warning("101", "counts_per_rev: 4096"), "");
  EXPECT_EQ(warning("101", "counts_per_rev: 4096, gear_ratio: 101"), "");
  EXPECT_EQ(warning("36.167452", "counts_per_rev: 4096, gear_ratio: 36.17"), "");  // rounded
  EXPECT_EQ(warning("1", "counts_per_rev: 4096, gear_ratio: 100"), "");            // a template's placeholder
  EXPECT_EQ(warning("101", "resolution: 1 mrad"), "");                             // at the joint
}

TEST_F(SpecOfAUrdf, SaysWhichTransmissionsItDoesNotUse) {
  const auto warnings = [&](const std::string& more) {
    std::string all;
    for (const std::string& w : spec_with(two_joints(limit, limit, more), bits).warnings) all += w + '\n';
    return all;
  };
  const std::string simple =
      "<transmission name='s'><joint name='bc'/><actuator "
      "name='p'><mechanicalReduction>30</mechanicalReduction>"
      "</actuator></transmission>";
  const std::string roles =
      "<transmission name='t'><type>transmission_interface/DifferentialTransmission</type>"
      "<joint name='ab'><role>joint1</role></joint><joint name='bc'><role>joint2</role></joint>"
      "<actuator name='m'><role>actuator1</role><mechanicalReduction>50</mechanicalReduction></actuator>"
      "<actuator name='n'><role>actuator2</role><mechanicalReduction>40</mechanicalReduction></actuator>"
      "</transmission>";
  EXPECT_EQ(warnings(roles).find("role"), std::string::npos) << warnings(roles);
  EXPECT_NE(warnings(roles + simple)
                .find("joint 'bc': the mechanical reduction is not used: the joint is moved by 't'"),
            std::string::npos)
      << warnings(roles + simple);
  std::string none = roles;
  for (const char* role : {"<role>joint1</role>", "<role>actuator2</role>"}) {
    const std::size_t at = none.find(role);
    none.erase(at, std::string(role).size());
  }
  EXPECT_NE(warnings(none).find("taken in their order"), std::string::npos) << warnings(none);
  EXPECT_NE(warnings("<gazebo>" + simple + "</gazebo>").find("inside of <gazebo>"), std::string::npos);
  EXPECT_NE(warnings("<link name='d'/><joint name='cd' type='revolute'><parent link='c'/><child link='d'/>" +
                     limit +
                     "<axis xyz='0 0 1'/><mimic joint='ab'/></joint><transmission name='s'><joint name='cd'/>"
                     "<mechanicalReduction>30</mechanicalReduction></transmission>")
                .find("the joint follows 'ab'"),
            std::string::npos);
  const std::string drake =
      "<transmission name='s'><joint name='bc'/><actuator name='p'><drake:gear_ratio value='30'/></actuator>"
      "</transmission>";
  EXPECT_NEAR(spec_of(two_joints(limit, limit, drake)).model.transmission.encoders[1].shaft_ratio, 30, 1e-12);
}

TEST_F(SpecOfAUrdf, WarnsOfACouplingThatTheUrdfContradicts) {
  const auto part = [](const std::string& tag, const std::string& name, const std::string& role,
                       const std::string& ratio) {
    return "<" + tag + " name='" + name + "'><role>" + tag + role + "</role><mechanicalReduction>" + ratio +
           "</mechanicalReduction></" + tag + ">";
  };
  const std::string urdf =
      two_joints(limit, limit,
                 "<transmission name='t'><type>transmission_interface/DifferentialTransmission</type>" +
                     part("joint", "ab", "1", "1") + part("joint", "bc", "2", "2") +
                     part("actuator", "m", "1", "50") + part("actuator", "n", "2", "40") + "</transmission>");
  const auto warning = [&](const std::string& more) {
    const Spec spec = spec_with(urdf, more);
    return spec.warnings.empty() ? "" : spec.warnings.front();
  };
  const std::string motors =
      "encoders: {ab: {counts_per_rev: 4096, gear_ratio: 50}, bc: {counts_per_rev: 4096, gear_ratio: 40}}\n";
  EXPECT_EQ(warning(motors + "coupling: [[0.5, 0.5], [0.25, -0.25]]\n"), "");
  EXPECT_EQ(
      warning("encoders: {ab: {counts_per_rev: 4096, gear_ratio: 40}, bc: {counts_per_rev: 4096, gear_ratio: "
              "50}}\ncoupling: [[0.5, 0.5], [-0.25, 0.25]]\n"),
      "")
      << "the same motors in the other order";
  const std::string found = warning(motors);
  EXPECT_NE(found.find("gear_ratio 50 and 40, coupling [[0.5, 0.5], [0.25, -0.25]]"), std::string::npos)
      << found;
  EXPECT_NE(warning(motors + "coupling: [[0.5, 0.5], [0.25, 0.26]]\n"), "");
  const Spec half = parse_spec("qerr: 1\nrobot: {urdf: robot.urdf, tip: b}\nencoders: {ab: {bits: 17}}\n",
                               (folder_ / "spec.yaml").string());
  ASSERT_EQ(half.warnings.size(), 1u);
  EXPECT_NE(half.warnings[0].find("'bc', which is not between"), std::string::npos) << half.warnings[0];
}

TEST_F(SpecOfAUrdf, WarnsOfACouplingOfEncodersAtTheJoints) {
  const auto warnings = [&](const std::string& entry) {
    return spec_with(two_joints(limit, limit),
                     "encoders: {'*': {" + entry + "}}\ncoupling: [[1, 0], [-1, 0.6]]\n")
        .warnings;
  };
  for (const char* at_joint : {"bits: 14", "resolution: 1 mrad"}) {
    const auto said = warnings(at_joint);
    ASSERT_EQ(said.size(), 1u) << at_joint;
    EXPECT_NE(said[0].find("coupling multiplies the encoders of 'bc', too"), std::string::npos) << said[0];
  }
  EXPECT_TRUE(warnings("counts_per_rev: 1200, gear_ratio: 100").empty());
}

TEST_F(SpecOfAUrdf, LetsACopyOfAPatternKeepTheTravelOfItsSlides) {
  const std::string urdf = two_joints(limit, limit, "", "prismatic");
  const std::string pattern = "encoders: {'*': {counts_per_rev: 4096, gear_ratio: 5, travel_per_rev: 10 mm}";
  const Spec copy =
      spec_with(urdf, pattern + ", ab: {counts_per_rev: 8192, gear_ratio: 5, travel_per_rev: 10 mm}}\n");
  EXPECT_DOUBLE_EQ(copy.model.transmission.encoders[0].resolution, 2 * std::numbers::pi / (8192 * 5));
  EXPECT_NE(
      refusal_of(urdf, pattern + ", ab: {counts_per_rev: 8192, gear_ratio: 5, travel_per_rev: 20 mm}}\n")
          .find("no travel per revolution"),
      std::string::npos);
}

TEST_F(SpecOfAUrdf, WarnsOnceWhereEveryRangeIsEmpty) {
  const std::string zero = "<limit lower='0' upper='0' effort='0' velocity='0'/>";
  const Spec spec = spec_with(two_joints(zero, zero), bits);
  ASSERT_EQ(spec.warnings.size(), 1u);
  EXPECT_NE(spec.warnings[0].find("a single configuration"), std::string::npos) << spec.warnings[0];
  EXPECT_NE(spec.warnings[0].find("'ab' at 0, 'bc' at 0"), std::string::npos) << spec.warnings[0];
  const Spec widened =
      spec_with(two_joints(zero, zero), bits + "configurations: {limits: {ab: [-1, 1], bc: [0, 1]}}\n");
  EXPECT_TRUE(widened.warnings.empty());
  EXPECT_EQ(widened.configurations.ranges[0].upper, 1);
}

TEST_F(SpecOfAUrdf, IsWarnedOfEffortLimitsInPlaceOfTheLoadsOfKnownMasses) {
  const auto warned = [&](const std::string& mass, const std::string& more) {
    const std::string urdf = robot("<link name='a'/><link name='b'><inertial><mass value='" + mass +
                                   "'/></inertial></link>" + joint("ab", "revolute", "a", "b"));
    const auto warnings = analyze(spec_with(urdf, bits + "configurations: {count: 10}\n" + more)).warnings;
    return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("the loads of 'ab' are +- the effort limits") != std::string::npos;
    });
  };
  const std::string soft = "effects: [{type: compliance, joint: ab, compliance: 1e-5}]\n";
  EXPECT_TRUE(warned("2", soft));
  EXPECT_FALSE(warned("0", soft)) << "no masses";
  EXPECT_FALSE(warned("2", "")) << "no load";
  EXPECT_FALSE(
      warned("2", soft + "motion: {sample_rate: 100 Hz, duration: 1 s, joints: {ab: {center: 0.5}}}\n"));
}

TEST_F(SpecOfAUrdf, NamesAPrismaticJointThatHasNoRange) {
  const std::string said =
      refusal_of(two_joints(limit, "", "", "prismatic"), "encoders: {'*': {resolution: 1e-6}}\n");
  EXPECT_NE(said.find("joint 'bc': the prismatic joint has no limits"), std::string::npos) << said;
  EXPECT_NE(said.find("bc: [0, 500 mm]"), std::string::npos) << said;
}

TEST_F(SpecOfAUrdf, IsAskedForWhereAUrdfIsGivenInItsPlace) {
  const auto said = [](const std::string& text) {
    try {
      parse_spec(text, "arm.urdf");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const std::string urdf = said("\n<?xml version='1.0'?>\n<robot name='r'/>");
  EXPECT_NE(urdf.find("arm.urdf:1:1: this is a URDF, not a spec"), std::string::npos) << urdf;
  EXPECT_NE(urdf.find("qerr robot arm.urdf --write-spec"), std::string::npos) << urdf;
  EXPECT_NE(said("<robot xmlns:xacro='x'><xacro:arm/></robot>").find("xacro arm.urdf | qerr robot -"),
            std::string::npos);
}

}  // namespace
}  // namespace qerr
