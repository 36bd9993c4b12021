#include <gtest/gtest.h>

#include "qerr/input/spec.hpp"

namespace qerr {
namespace {

Spec one_joint(const std::string& robot) {
  const bool prismatic = robot.find("prismatic") != std::string::npos;
  return parse_spec("qerr: 1\nrobot: {" + robot + "}\nencoders: {table: {" +
                        (prismatic ? "resolution: 1 um}}\n" : "bits: 14}}\n"),
                    "bench.yaml");
}

std::string fault(const std::string& robot) {
  try {
    one_joint(robot);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(OneJoint, TheRadiusPlacesTheTip) {
  const Spec spec = one_joint("joint: {name: table, type: revolute, radius: 100 mm}");
  ASSERT_EQ(spec.model.chain.independent.size(), 1u);
  EXPECT_EQ(spec.model.chain.independent[0].name, "table");
  EXPECT_DOUBLE_EQ(spec.model.chain.tip_offset.translation().x(), 0.1);
  EXPECT_EQ(spec.model.chain.joints[0].axis.z(), 1);
}

TEST(OneJoint, MayBePrismaticAndHaveLimits) {
  const Spec slide = one_joint("joint: {name: table, type: prismatic}");
  EXPECT_TRUE(slide.model.chain.independent[0].prismatic());
  // Its errors do not depend on the position: any range serves.
  EXPECT_LT(slide.configurations.ranges[0].lower, slide.configurations.ranges[0].upper);
  const Spec spec = one_joint("joint: {name: table, type: revolute, limits: [-1, 2]}");
  EXPECT_EQ(spec.model.chain.independent[0].limits->upper, 2);
}

TEST(OneJoint, WithoutRadiusHasItsJointAsTheCoordinate) {
  using List = std::vector<Coordinate>;
  EXPECT_EQ(one_joint("joint: {name: table, type: revolute}").model.coordinates, List{Coordinate::rz});
  EXPECT_EQ(one_joint("joint: {name: table, type: revolute, radius: 0}").model.coordinates,
            List{Coordinate::rz});
  EXPECT_EQ(one_joint("joint: {name: table, type: prismatic}").model.coordinates, List{Coordinate::x});
  EXPECT_EQ(one_joint("joint: {name: table, type: revolute, radius: 100 mm}").model.coordinates.size(), 3u);
}

TEST(OneJoint, FaultsNameTheRule) {
  EXPECT_NE(fault("urdf: a.urdf, joint: {name: table}").find("one of"), std::string::npos);
  EXPECT_NE(fault("base: a").find("'joint'"), std::string::npos);
  EXPECT_NE(fault("joint: {name: table, type: prismatic, radius: 1}").find("only a revolute"),
            std::string::npos);
}

}  // namespace
}  // namespace qerr
