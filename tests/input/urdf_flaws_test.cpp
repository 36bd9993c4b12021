#include <gtest/gtest.h>

#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/kinematics/chain.hpp"
#include "support/urdf_text.hpp"

// A flaw of a URDF is an error of the chains that use the joint or link that it concerns, and of no other.
namespace qerr {
namespace {

using namespace testing::urdf;

/// Two branches of one joint each: a -ab-> b, a -ac-> c; `inside` belongs to the joint ac.
std::string branches(const std::string& inside, const std::string& type = "revolute") {
  return robot(links + joint("ab", "revolute", "a", "b") + "\n" + joint("ac", type, "a", "c", inside));
}

std::string chain_error(const RobotModel& model, const std::string& base, const std::string& tip) {
  try {
    make_chain(model, base, tip);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(UrdfFlaws, OfAJointSpoilTheChainsThroughIt) {
  const std::pair<std::string, const char*> flawed[] = {
      {branches("<axis xyz='0 0 0'/>" + limit), "must not be zero"},
      {branches("<axis xyz='0 0 one'/>" + limit), "3 finite numbers"},
      {branches("<limit lower='2' upper='1' effort='1' velocity='1'/>"), "must not exceed"},
      {branches(limit + "<mimic joint='nobody'/>"), "unknown joint to mimic"},
      {branches(limit + "<mimic joint='ac'/>"), "cannot mimic itself"},
      {branches(limit + "<orign xyz='1 0 0'/>"), "did you mean <origin>"},
      {branches(limit, "hinge"), "unknown joint type"},
      {branches(limit + "<mimic joint='ab' multiplier='two'/>"), "must be a finite number"},
  };
  for (const auto& [text, message] : flawed) {
    const RobotModel model = read(text);
    EXPECT_EQ(chain_error(model, "", "b"), "") << message;
    const std::string refused = chain_error(model, "", "c");
    EXPECT_EQ(refused.find("r.urdf:3:"), 0u) << refused;
    EXPECT_NE(refused.find(message), std::string::npos) << refused;
    const std::vector<std::string> warnings = warnings_about(model, make_chain(model, "", "b"));
    ASSERT_EQ(warnings.size(), 1u) << message;
    EXPECT_NE(warnings[0].find(message), std::string::npos) << warnings[0];
    EXPECT_NE(warnings[0].find("not used"), std::string::npos) << warnings[0];
  }
}

TEST(UrdfFlaws, OfTheMasterSpoilTheMimic) {
  const RobotModel model =
      read(robot(links + joint("ab", "revolute", "a", "b", limit + "<mimic joint='ac'/>") +
                 joint("ac", "revolute", "a", "c", "<axis xyz='0 0 0'/>" + limit)));
  EXPECT_NE(chain_error(model, "", "b").find("must not be zero"), std::string::npos);
}

TEST(UrdfFlaws, OfDuplicateLinksAndParentsSpoilOnlyThatLink) {
  const RobotModel twice =
      read(branches(limit).insert(std::string("<robot name='r'>\n").size(), "<link name='c'/>"));
  EXPECT_EQ(chain_error(twice, "", "b"), "");
  EXPECT_NE(chain_error(twice, "", "c").find("duplicate name of a link"), std::string::npos);
  const RobotModel parents = read(robot(
      links + "<link name='d'/>" + joint("ab", "revolute", "a", "b") + joint("ac", "revolute", "a", "c") +
      joint("ad", "revolute", "a", "d") + joint("bc", "fixed", "b", "c", "")));
  EXPECT_EQ(chain_error(parents, "", "d"), "");
  EXPECT_NE(chain_error(parents, "", "c").find("must have one parent"), std::string::npos);
}

TEST(UrdfFlaws, ThatCutTheTreeSpoilTheChainAcrossTheCut) {
  const RobotModel cut =
      read(robot(links + joint("ab", "revolute", "nowhere", "b") + joint("bc", "revolute", "b", "c")));
  EXPECT_NE(chain_error(cut, "", "c").find("'nowhere'"), std::string::npos);
  EXPECT_NE(chain_error(cut, "a", "c").find("'nowhere'"), std::string::npos);
  EXPECT_EQ(chain_error(cut, "b", "c"), "");
}

TEST(UrdfFlaws, ThatLoseTheFirstMovingJointAreErrorsUnlessABaseIsNamed) {
  const std::string two = "<link name='b'/><link name='c'/>" + joint("bc", "revolute", "b", "c");
  const RobotModel moving = read(robot(two + joint("ab", "revolute", "nowhere", "b")));
  EXPECT_NE(chain_error(moving, "", "").find("'nowhere'"), std::string::npos);
  EXPECT_EQ(chain_error(moving, "b", ""), "");
  const RobotModel fixed = read(robot(two + joint("ab", "fixed", "nowhere", "b", "")));
  EXPECT_EQ(chain_error(fixed, "", ""), "");
}

TEST(UrdfFlaws, OfASecondRootNeedABase) {
  const RobotModel island = read(robot(links + joint("ab", "revolute", "a", "b")));
  EXPECT_NE(chain_error(island, "", "b").find("one root link, found 2 roots"), std::string::npos);
  EXPECT_EQ(chain_error(island, "a", "b"), "");
}

TEST(UrdfFlaws, OnWhichNoFigureDependsAreWarningsEverywhere) {
  const std::pair<std::string, const char*> flawed[] = {
      {"<robot><link name='a'/></robot>", "a robot must have a name"},
      {inside_joint("<limit lower='0' upper='1' velocity='1'/>"), "must have 'effort'"},
      {inside_joint("<limit lower='0' upper='1' effort='1'/>"), "must have 'velocity'"},
      {inside_joint("<limit lower='0' upper='1' effort='-1' velocity='1'/>"),
       "'effort' of <limit> must not be negative"},
      {inside_joint("<limit lower='0' upper='1' effort='much' velocity='1'/>"),
       "'effort' of <limit> must be a finite"},
      {inside_joint("<limit lower='0' upper='1' effort='1' velocity='1' k_velocity='1'/>"),
       "unknown attribute"},
      {robot("<link name='a'><inertial><inertia iyx='1'/></inertial></link>"),
       "unknown attribute of <inertia>"},
      {robot("<link name='a'><inertia ixx='1'/></link>"), "did you mean <inertial>"},
  };
  for (const auto& [text, message] : flawed) {
    const RobotModel model = read_strictly(text);
    ASSERT_EQ(warnings(model).size(), 1u) << message;
    EXPECT_NE(warnings(model)[0].find(message), std::string::npos) << warnings(model)[0];
  }
}

TEST(UrdfFlaws, OfOneKindAreOneWarning) {
  const std::string weak = "<limit lower='0' upper='1' effort='-1' velocity='1'/>";
  const RobotModel model =
      read(robot(links + joint("ab", "revolute", "a", "b", weak) + joint("bc", "revolute", "b", "c", weak)));
  const std::vector<std::string> warnings = warnings_about(model, make_chain(model, "", ""));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("joint 'ab'"), std::string::npos);
  EXPECT_NE(warnings[0].find("1 more time"), std::string::npos);
}

TEST(UrdfFlaws, AnImpossibleRangeIsNoLimit) {
  for (const char* range : {"lower='-1e16' upper='1e16'", "lower='-inf' upper='inf'",
                            "lower='-1' upper='1e9'", "lower='-Infinity' upper='0'"}) {
    const RobotModel model =
        read(inside_joint("<limit " + std::string(range) + " effort='1' velocity='1'/>"));
    EXPECT_FALSE(model.joints[0].limits) << range;
    EXPECT_EQ(warnings(model).size(), 1u) << range;
  }
  const RobotModel turns = read(inside_joint("<limit lower='-628' upper='628' effort='1' velocity='1'/>"));
  ASSERT_TRUE(turns.joints[0].limits);
  EXPECT_EQ(turns.joints[0].limits->upper, 628);
}

TEST(UrdfFlaws, ManyEndInTime) {
  std::string text = "<robot name='r'><link name='a'/>";
  for (int i = 0; i < 3000; ++i) text += "<link name='l" + std::to_string(i) + "'/>";
  for (int i = 0; i < 3000; ++i)
    text += joint("j" + std::to_string(i), "revolute", "a", "l" + std::to_string(i),
                  limit + "<mimic joint='x'/>");
  EXPECT_NE(refusal(text + "</robot>").find("more faults"), std::string::npos);
}

/// Ratios of joint ab as different writers state them.
TEST(StatedRatios, AreReadFromEveryFormOfTransmission) {
  const std::pair<std::string, double> written[] = {
      {"<transmission name='t'><type>SimpleTransmission</type><joint name='ab'/><actuator name='m'>"
       "<mechanicalReduction> 101 </mechanicalReduction></actuator></transmission>",
       101},
      {"<transmission name='t' type='SimpleTransmission'><actuator name='m'/><joint name='ab'/>"
       "<mechanicalReduction>-36.5</mechanicalReduction></transmission>",
       -36.5},
      {"<ros2_control name='c' type='system'><transmission name='t'><actuator name='m' role='a'/>"
       "<joint name='ab' "
       "role='j'><mechanical_reduction>2.5</mechanical_reduction><offset>0.1</offset></joint>"
       "</transmission></ros2_control>",
       2.5},
      {"<ros2_control name='c' type='system'><joint name='ab'><command_interface name='position'/>"
       "<param name='mechanical_reduction'>50</param></joint></ros2_control>",
       50},
      {"<transmission name='t'><joint name='ab'><mechanicalReduction>1</mechanicalReduction></joint>"
       "<actuator name='m'><mechanicalReduction>80</mechanicalReduction></actuator></transmission>",
       80}};
  for (const auto& [text, ratio] : written) {
    const RobotModel model =
        read(robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "fixed", "b", "c") + text));
    ASSERT_TRUE(model.joints[0].stated_ratio) << text;
    EXPECT_EQ(*model.joints[0].stated_ratio, ratio);
    EXPECT_FALSE(model.joints[1].stated_ratio);
    EXPECT_TRUE(warnings(model).empty());
  }
}

TEST(StatedRatios, OfADifferentialAreNotThoseOfAJoint) {
  const RobotModel model =
      read(robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "revolute", "b", "c") +
                 "<transmission name='t'><joint name='ab'/><joint name='bc'/><actuator name='m'>"
                 "<mechanicalReduction>50</mechanicalReduction></actuator></transmission>"));
  EXPECT_FALSE(model.joints[0].stated_ratio);
}

TEST(StatedRatios, ThatAreNoNumbersOrContradictEachOtherAreWarnings) {
  const auto model_of = [](const std::string& ratio) {
    return read(robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "fixed", "b", "c") +
                      "<transmission name='t'><joint name='ab'/><mechanicalReduction>50</mechanicalReduction>"
                      "</transmission><transmission name='u'><joint name='ab'/><mechanicalReduction>" +
                      ratio + "</mechanicalReduction></transmission>"));
  };
  for (const char* ratio : {"1:50", "", "0"}) {
    const RobotModel model = model_of(ratio);
    EXPECT_EQ(warnings(model).size(), 1u) << ratio;
    EXPECT_EQ(model.joints[0].stated_ratio, 50);
  }
  const RobotModel two = model_of("100");
  EXPECT_EQ(warnings(two).size(), 1u);
  EXPECT_FALSE(two.joints[0].stated_ratio) << "neither is more credible than the other";
}

std::string reduction(const std::string& tag, const std::string& name, const std::string& ratio,
                      const std::string& more = "") {
  return "<" + tag + " name='" + name + "'>" + more + "<mechanicalReduction>" + ratio +
         "</mechanicalReduction></" + tag + ">";
}

RobotModel with_transmission(const std::string& type, const std::string& parts,
                             const std::string& joints = limit) {
  return read(robot(
      links + joint("ab", "revolute", "a", "b", joints) + joint("bc", "revolute", "b", "c", joints) +
      "<transmission name='t'><type>transmission_interface/" + type + "</type>" + parts + "</transmission>"));
}

TEST(StatedRatios, DoNotDependOnTheOrderOfTheTags) {
  const std::string of_joint = reduction("joint", "ab", "2"), of_motor = reduction("actuator", "m", "30");
  for (const std::string& parts : {of_joint + of_motor, of_motor + of_joint}) {
    const RobotModel model = with_transmission("SimpleTransmission", parts);
    EXPECT_EQ(model.joints[0].stated_ratio, 30) << "ROS takes that of the actuator";
    ASSERT_EQ(warnings(model).size(), 1u);
    EXPECT_NE(warnings(model)[0].find("'30' and '2'"), std::string::npos) << warnings(model)[0];
  }
}

/// Motors' angles of a transmission for joint angles, as ros_control computes them (joint_to_actuator).
Eigen::Vector2d motors(const std::string& type, const Eigen::Vector2d& n, const Eigen::Vector2d& j,
                       const Eigen::Vector2d& q) {
  if (type == "DifferentialTransmission")
    return {n[0] * (j[0] * q[0] + j[1] * q[1]), n[1] * (j[0] * q[0] - j[1] * q[1])};
  return {n[0] * j[0] * q[0], n[1] * (q[0] + j[1] * q[1])};
}

TEST(StatedCouplings, AreTheInverseOfTheEquationsOfRosControl) {
  const Eigen::Vector2d n(50, -40), j(-2, 0.5), q(0.3, -1.1);
  for (const std::string type : {"DifferentialTransmission", "FourBarLinkageTransmission"})
    for (const bool reversed : {false, true}) {  // the roles say which joint is which
      const auto part = [&](const char* tag, const char* name, int k, double ratio) {
        return reduction(tag, name, shortest(ratio),
                         "<role>" + std::string(tag) + std::to_string(k + 1) + "</role>");
      };
      const std::string first = part("joint", "ab", 0, j[0]) + part("actuator", "m1", 0, n[0]),
                        second = part("joint", "bc", 1, j[1]) + part("actuator", "m2", 1, n[1]);
      const RobotModel model = with_transmission(type, reversed ? second + first : first + second);
      ASSERT_EQ(model.couplings.size(), 1u) << type;
      const StatedCoupling& c = model.couplings[0];
      EXPECT_EQ(c.joints[0], "ab");
      const Eigen::Vector2d m = motors(type, n, j, q);
      const Eigen::Vector2d back = c.coupling * Eigen::Vector2d(m[0] / c.ratios[0], m[1] / c.ratios[1]);
      EXPECT_NEAR((back - q).norm(), 0, 1e-14) << type;
      EXPECT_FALSE(model.joints[0].stated_ratio);
      EXPECT_TRUE(warnings(model).empty());
    }
}

TEST(StatedCouplings, ThatAreNotReadAreSaid) {
  const std::string two = reduction("joint", "ab", "3") + reduction("joint", "bc", "2"),
                    motors = reduction("actuator", "m", "50") + reduction("actuator", "n", "50");
  const std::string mimic = limit + "<mimic joint='ab'/>";
  const std::pair<RobotModel, const char*> unread[] = {
      {with_transmission("FingerTransmission", two + reduction("actuator", "m", "50")),
       "its equations are not known"},
      {with_transmission("DifferentialTransmission", two), "two joints and two actuators"},
      {with_transmission("DifferentialTransmission",
                         two + reduction("actuator", "m", "50") + reduction("actuator", "n", "0")),
       "a number other than 0"},
      {read(robot(links + joint("ab", "revolute", "a", "b") + joint("bc", "revolute", "b", "c", mimic) +
                  "<transmission name='t'><type>DifferentialTransmission</type>" + two + motors +
                  "</transmission>")),
       "'bc' is a mimic joint"}};
  for (const auto& [model, why] : unread) {
    EXPECT_TRUE(model.couplings.empty()) << why;
    ASSERT_EQ(warnings(model).size(), 1u) << why;
    EXPECT_NE(warnings(model)[0].find(why), std::string::npos) << warnings(model)[0];
    const std::vector<std::string> of_chain = warnings_about(model, make_chain(model, "", "c"));
    ASSERT_EQ(of_chain.size(), 1u) << "every command that uses the joints says so, too";
  }
}

TEST(StatedRatios, ThatRosReadsOtherwiseAreSaid) {
  const auto model_of = [](const std::string& type, const std::string& actuator) {
    return read(robot(links + joint("ab", "revolute", "a", "b", limit) + "<transmission name='t'><type>" +
                      type + "</type><joint name='ab'/>" + actuator + "</transmission>"));
  };
  EXPECT_TRUE(warnings(model_of("x/SimpleTransmission", reduction("actuator", "m", "50"))).empty());
  const RobotModel piston = model_of("x/PistonTransmission", reduction("actuator", "m", "50")),
                   attribute =
                       model_of("SimpleTransmission", "<actuator name='m' mechanicalReduction='50'/>");
  ASSERT_EQ(warnings(piston).size(), 1u);
  EXPECT_NE(warnings(piston)[0].find("PistonTransmission of 'ab' are not known"), std::string::npos);
  ASSERT_EQ(warnings(attribute).size(), 1u);
  EXPECT_NE(warnings(attribute)[0].find("as an element only"), std::string::npos) << warnings(attribute)[0];
  std::string shared;
  for (const char* moved : {"ab", "bc"})
    shared += std::string("<transmission name='") + moved + "'><type>SimpleTransmission</type><joint name='" +
              moved + "'/>" + reduction("actuator", "m", "50") + "</transmission>";
  const RobotModel one_motor = read(robot(links + joint("ab", "revolute", "a", "b", limit) +
                                          joint("bc", "revolute", "b", "c", limit) + shared));
  ASSERT_EQ(warnings(one_motor).size(), 1u);
  EXPECT_NE(warnings(one_motor)[0].find("actuator 'm' moves 'ab', too"), std::string::npos);
}

TEST(StatedRatios, OfAPrismaticJointAreRadiansPerMetre) {
  const auto model_of = [](const char* ratio) {
    return read(robot(
        links + joint("ab", "prismatic", "a", "b", "<limit lower='0' upper='0.4' effort='1' velocity='1'/>") +
        "<transmission name='t'>" + reduction("actuator", "m", ratio) + "<joint name='ab'/></transmission>"));
  };
  EXPECT_TRUE(warnings(model_of("1256.637")).empty());  // a screw of 5 mm
  const RobotModel gear = model_of("3");
  ASSERT_EQ(warnings(gear).size(), 1u);
  EXPECT_NE(warnings(gear)[0].find("2.09 m a revolution"), std::string::npos) << warnings(gear)[0];
}

}  // namespace
}  // namespace qerr
