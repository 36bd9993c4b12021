#include "qerr/report/robot_report.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "core/text.hpp"
#include "support/urdf_text.hpp"

namespace qerr {
namespace {

using namespace testing::urdf;

RobotReport report_of(const std::string& urdf) { return robot_report(read(urdf), urdf); }

std::string table(const std::string& urdf) { return write(report_of(urdf), "table"); }

TEST(RobotReport, ShowsTreeJointsEndsAndFlaws) {
  const std::string text = table(robot(
      links + "<link name='imu'/>" + joint("ab", "revolute", "a", "b", "<axis xyz='0 -1 0'/>" + limit) +
      joint("bc", "prismatic", "b", "c",
            "<limit lower='0' upper='0.4' effort='-2' velocity='0.1'/><mimic joint='ab' multiplier='0.1'/>") +
      joint("bi", "fixed", "b", "imu", "") +
      "<transmission name='t'><joint "
      "name='ab'/><mechanicalReduction>50</mechanicalReduction></transmission>"));
  for (const char* part :
       {"r: 4 links, 2 moving joints (1 prismatic and 1 revolute; 1 mimic), 2 ends", "ab: b + imu", "bc: c",
        "revolute    -y  -57.3  114.6       3  229.2     50", "prismatic     x      0    400       -    100",
        "bc = 0.1 * ab", "line 2: joint 'bc': 'effort' of <limit> must not be negative",
        "qerr robot r.urdf --write-spec spec.yaml"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
  EXPECT_LT(text.find("\n  c  "), text.find("\n  imu  ")) << "the end with more joints is first\n" << text;
}

TEST(RobotReport, FitsEightyColumnsWhateverTheNames) {
  const std::string longest(70, 'n');
  std::string body = "<link name='base" + longest + "'/>", parent = "base" + longest;
  for (int i = 0; i < 60; ++i) {
    const std::string child = "link" + longest + std::to_string(i);
    body += "<link name='" + child + "'/>" +
            joint("joint" + longest + std::to_string(i), i % 2 ? "revolute" : "prismatic", parent, child,
                  "<axis xyz='0.6 0.64 0.48'/><limit lower='-1234.5678' upper='1234.5678' effort='-1' "
                  "velocity='1234.5678'/>" +
                      std::string(i % 7 == 3 ? "<mimic joint='joint" + longest + "0' multiplier='-0.333333'/>"
                                             : ""));
    body += "<transmission name='t'><joint name='joint" + longest + std::to_string(i) +
            "'/><mechanicalReduction>-12345.678</mechanicalReduction></transmission>";
    if (i % 3) parent = child;
  }
  std::istringstream lines(table(robot(body)));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 80u) << line;
}

TEST(RobotReport, HasEverythingInItsJson) {
  const auto json = nlohmann::json::parse(write(
      report_of(robot(links + joint("ab", "revolute", "a", "b") +
                      joint("bc", "prismatic", "b", "c", "<mimic joint='ab' multiplier='2' offset='1'/>"))),
      "json"));
  EXPECT_EQ(json["command"], "robot");
  EXPECT_EQ(json["robot"]["roots"], nlohmann::json::array({"a"}));
  EXPECT_EQ(json["first_spec"]["tip"], "c");
  EXPECT_EQ(json["joints"][0]["limits"]["upper"], 2);
  EXPECT_EQ(json["joints"][0]["effort"], 3);
  EXPECT_EQ(json["joints"][0]["velocity"], 4);
  EXPECT_TRUE(json["joints"][0]["mimic"].is_null());
  EXPECT_EQ(json["joints"][1]["mimic"]["multiplier"], 2);
  EXPECT_EQ(json["joints"][1]["unit"], "m");
  EXPECT_TRUE(json["joints"][1]["limits"].is_null());
  EXPECT_EQ(json["ends"][0]["moving_joints"], 2);
  EXPECT_EQ(json["ends"][0]["joints"], nlohmann::json::array({"ab", "bc"}));
  EXPECT_EQ(json["flaws"][0]["severity"], "warning");
}

TEST(RobotReport, SaysWhyNoChainCanBeAnalyzed) {
  const std::string text =
      table(robot(links + joint("ab", "revolute", "a", "b", "<axis xyz='0 0 0'/>" + limit) +
                  joint("bc", "fixed", "b", "c", "")));
  EXPECT_NE(text.find("No chain can be analyzed: r.urdf:2:"), std::string::npos) << text;
  EXPECT_NE(table(robot("<link name='a'/>")).find("no joint of this robot moves"), std::string::npos);
}

TEST(RobotReport, WarnsOfPosesOutsideTheLimits) {
  const RobotModel arm =
      read(robot(links + "<link name='d'/>" + joint("ab", "revolute", "a", "b", limit) +
                 joint("bc", "continuous", "b", "c", "") + joint("cd", "prismatic", "c", "d", limit)));
  const Chain chain = first_chain(arm, "a", "d");
  const auto warned = [&](const std::string& at) { return pose_at(arm, chain, {at}).warnings; };
  for (const char* within : {"ab=0.5", "ab=90deg", "bc=-6", "cd=1"})
    EXPECT_TRUE(warned(within).empty()) << within;
  for (const auto& [outside, part] : {std::pair{"ab=90", "outside its limits [-1, 2] rad; degrees need"},
                                      {"ab=300deg", "outside its limits [-1, 2] rad"},
                                      {"bc=30", "more than a turn"},
                                      {"cd=400", "outside its limits"}}) {
    ASSERT_EQ(warned(outside).size(), 1U) << outside;
    EXPECT_NE(warned(outside)[0].find(part), std::string::npos) << warned(outside)[0];
  }
  EXPECT_EQ(warned("ab=300deg")[0].find("degrees"), std::string::npos);
}

TEST(RobotReport, HasAMovingJointInEachRowOfItsCsv) {
  const std::string csv =
      write(report_of(robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "fixed", "b", "c", ""))),
            "csv");
  EXPECT_NE(csv.find("ab,revolute,a,b,1,0,0,rad,-1,2,3,4,,,,\r\n"), std::string::npos) << csv;
  EXPECT_EQ(csv.find("bc,"), std::string::npos);
}

}  // namespace
}  // namespace qerr
