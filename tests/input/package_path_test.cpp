#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "input/urdf_reader.hpp"
#include "qerr/core/error.hpp"

namespace qerr {
namespace {

namespace fs = std::filesystem;

/// A workspace of ROS: `installed/share/arm`, and `src/group/leg` with its package.xml.
class PackagePath : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("qerr_packages_" + std::to_string(getpid()));
    fs::create_directories(folder_ / "installed/share/arm/urdf");
    fs::create_directories(folder_ / "src/group/leg/urdf");
    std::ofstream(folder_ / "installed/share/arm/urdf/arm.urdf") << "x";
    std::ofstream(folder_ / "src/group/leg/urdf/leg.urdf") << "x";
    std::ofstream(folder_ / "src/group/leg/package.xml") << "x";
    set("AMENT_PREFIX_PATH", "/nowhere:" + (folder_ / "installed").string());
    set("ROS_PACKAGE_PATH", (folder_ / "src").string());
  }
  void TearDown() override {
    unsetenv("AMENT_PREFIX_PATH");
    unsetenv("ROS_PACKAGE_PATH");
    fs::remove_all(folder_);
  }
  static void set(const char* variable, const std::string& value) { setenv(variable, value.c_str(), 1); }
  static std::string refusal(const std::string& given) {
    try {
      return "found " + urdf_path(given, "here");
    } catch (const Error& e) {
      return e.what();
    }
  }
  fs::path folder_;
};

TEST_F(PackagePath, WithoutASchemeIsRelativeToTheSpec) {
  EXPECT_EQ(urdf_path("arm.urdf", "here"), "here/arm.urdf");
  EXPECT_EQ(urdf_path("/arm.urdf", "here"), "/arm.urdf");
  EXPECT_EQ(urdf_path("file:///arm.urdf", "here"), "/arm.urdf");
}

TEST_F(PackagePath, IsFoundInBothKindsOfWorkspace) {
  EXPECT_EQ(urdf_path("package://arm/urdf/arm.urdf", "here"), folder_ / "installed/share/arm/urdf/arm.urdf");
  EXPECT_EQ(fs::canonical(urdf_path("package://leg/urdf/leg.urdf", "here")),
            fs::canonical(folder_ / "src/group/leg/urdf/leg.urdf"));
  set("ROS_PACKAGE_PATH", (folder_ / "src/group/leg").string());  // the package itself
  EXPECT_EQ(fs::canonical(urdf_path("package://leg/urdf/leg.urdf", "here")),
            fs::canonical(folder_ / "src/group/leg/urdf/leg.urdf"));
}

TEST_F(PackagePath, ThatIsNotFoundSaysWhereItWasLookedFor) {
  EXPECT_NE(refusal("package://hand/hand.urdf").find("package 'hand' is in no folder of AMENT_PREFIX_PATH"),
            std::string::npos);
  const std::string no_file = refusal("package://arm/urdf/arn.urdf");
  EXPECT_NE(no_file.find("package 'arm' has no file 'urdf/arn.urdf'"), std::string::npos) << no_file;
  unsetenv("AMENT_PREFIX_PATH");
  unsetenv("ROS_PACKAGE_PATH");
  EXPECT_NE(refusal("package://arm/urdf/arm.urdf").find("are not set"), std::string::npos);
  EXPECT_NE(refusal("model://arm/arm.urdf").find("must be a path, package://"), std::string::npos);
  EXPECT_NE(refusal("package://arm").find("must be a path, package://"), std::string::npos);
}

}  // namespace
}  // namespace qerr
