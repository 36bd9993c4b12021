#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "qerr/input/first_spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "simulate/sensing.hpp"

namespace qerr {
namespace {

constexpr const char* two_links = R"(<?xml version="1.0"?>
<robot name="arm"><!-- <joint name="b" type="revolute"><origin xyz="9 9 9"/> -->
  <link name="base"/><link name="plate"/><link name="upper"/><link name="hand"/>
  <transmission name="t"><type>x/SimpleTransmission</type><joint name="b"><mechanicalReduction>50</mechanicalReduction></joint></transmission>
  <joint name="a" type="revolute"><parent link="base"/><child link="plate"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="fixed" type="fixed"><origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><parent link="plate"/><child link="upper"/></joint>
  <joint name="b" type="revolute"><origin rpy='0.1 0 0' xyz='0.3 0 0.05'/><parent link="upper"/><child link="hand"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>
)";

struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("qerr_write_urdf_" + std::to_string(::getpid()));
  Folder() {
    std::filesystem::create_directories(path);
    std::ofstream(path / "arm.urdf") << two_links;
  }
  ~Folder() { std::filesystem::remove_all(path); }
};

Effect longer(const std::string& joint, const std::string& axis, double by) {
  return {"geometry", joint, {{"length", by}}, {{"axis", axis}}};
}

TEST(WriteUrdf, IsTheArmAsItWasFound) {
  const Folder folder;
  const std::string file = (folder.path / "spec.yaml").string();
  const Spec spec = parse_spec(
      "qerr: 1\nrobot: {urdf: arm.urdf}\nencoders: {'*': {bits: 12}}\n"
      "effects:\n  - {type: geometry, joint: b, axis: z, length: 1 mm}\n",
      file);
  const std::vector<Effect> found{longer("a", "y", 0.002), longer("b", "x", -0.003),
                                  longer("b", "z", 0.0005)};
  const std::string text = urdf_as_built(spec, found);
  EXPECT_NE(text.find("<origin xyz=\"9 9 9\"/> -->"), std::string::npos) << "a comment is no joint";
  EXPECT_NE(text.find("<origin rpy='0.1 0 0' xyz='0.297 0 0.0515'/>"), std::string::npos) << text;
  EXPECT_NE(text.find("type=\"revolute\"><origin xyz=\"0 0.002 0\"/><parent link=\"base\"/>"),
            std::string::npos)
      << text;

  std::ofstream(folder.path / "arm.urdf") << text;
  std::vector<Effect> all = spec.effects;
  all.insert(all.end(), found.begin(), found.end());
  const Chain built = as_built(spec.model.chain, all),
              read = make_chain(read_urdf((folder.path / "arm.urdf").string()), "", "");
  for (const double q : {-1.3, 0.0, 0.7}) {
    const Eigen::Vector2d joints(q, 0.4 - q);
    EXPECT_LT((forward_kinematics(built, joints).matrix() - forward_kinematics(read, joints).matrix()).norm(),
              1e-9);
  }
}

TEST(WriteUrdf, RefusesARobotWithoutAUrdf) {
  const Spec spec = parse_spec(
      "qerr: 1\nrobot: {joint: {name: j, type: revolute, radius: 0.3 m}}\nencoders: {j: {bits: 12}}\n",
      "s.yaml");
  EXPECT_THROW(urdf_as_built(spec, {}), Error);
}

}  // namespace
}  // namespace qerr
