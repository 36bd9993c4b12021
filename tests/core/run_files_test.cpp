#include "core/run_files.hpp"

#include <gtest/gtest.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/output_file.hpp"
#include "qerr/core/error.hpp"

namespace qerr {
namespace {

class FilesOfARun : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_run_files_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(file("spec.yaml")) << "robot: {}\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  /// The message of the refusal; "" if there is none.
  template <class Action>
  std::string refusal(Action action) {
    try {
      action();
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::usage);
      return e.what();
    }
    return "";
  }

  std::filesystem::path folder_;
  RunFiles run_;
};

TEST_F(FilesOfARun, RefuseAnOutputThatIsAnInputUnderAnyName) {
  std::filesystem::create_hard_link(file("spec.yaml"), file("hard.yaml"));
  std::filesystem::create_symlink(file("spec.yaml"), file("soft.yaml"));
  note_input(file("spec.yaml"));
  for (const char* name : {"spec.yaml", "hard.yaml", "soft.yaml", "./spec.yaml"})
    EXPECT_NE(refusal([&] { OutputFile out(file(name)); }).find(name), std::string::npos) << name;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 3) << "nothing is written";
}

TEST_F(FilesOfARun, RefuseAnInputThatIsAnOutput) {
  note_output(file("spec.yaml"));
  EXPECT_NE(refusal([&] { note_input(file("spec.yaml")); }).find("spec.yaml"), std::string::npos);
}

TEST_F(FilesOfARun, RefuseAnOutputThatReplacesASpec) {
  const auto written = [&](const std::string& name, const std::string& text) {
    std::ofstream(file(name)) << text;
    return refusal([&] { note_output(file(name)); });
  };
  int number = 0;
  for (const char* spec : {"# arm\n\nqerr: 1\n", "{qerr: 1, robot: {}}", "{\"qerr\": 1}", "  'qerr' : 1\n"})
    EXPECT_NE(written("s" + std::to_string(++number) + ".yaml", spec).find("--force"), std::string::npos)
        << spec;
  EXPECT_EQ(written("o.json", "{\n  \"qerr\": \"1.2\",\n"), "");
  EXPECT_EQ(written("other", "qerr is not a key\nqerrs: 1\n"), "");
  for (const char* quoting :
       {"<!DOCTYPE html>\n<pre>\nqerr: 1\n", ".TH QERR 7\nqerr: 1\n",
        "# Help\n\nSave (as a file) a spec:\n\nqerr: 1\n", "Save this, a spec, as arm.yaml:\nqerr: 1\n"})
    EXPECT_EQ(written("q" + std::to_string(++number), quoting), "") << quoting;
  permit_replacing_specs();
  EXPECT_EQ(written("forced.yaml", "qerr: 1\n"), "");
}

TEST_F(FilesOfARun, RefuseAnOutputThatReplacesWhatAPersonHasWritten) {
  const auto refused = [&](const std::string& name, const std::string& text, const char* option) {
    std::ofstream(file(name)) << text;
    return refusal([&] { note_output(file(name), option); }).find("--force") != std::string::npos;
  };
  for (const char* option : {"--output", "--write-spec", "--log"}) {
    const std::string o(option);
    EXPECT_TRUE(
        refused(o + "arm.urdf", "<?xml version='1.0'?>\n<!-- arm -->\n<robot name='arm'/>\n", option));
    for (const char* header :
         {"name,price,bits", "# of 2026\nname;bits", "\xef\xbb\xbf\"price [EUR]\", \"name\""})
      EXPECT_TRUE(refused(o + header[0] + ".csv", std::string(header) + "\na,1,2\n", option)) << header;
    const bool any = o == "--write-spec";
    EXPECT_EQ(refused(o + "notes.txt", "some notes\n", option), any);
    EXPECT_EQ(refused(o + "other.csv", "section,name,statistic,unit,a,b,change\n", option), any);
    EXPECT_EQ(refused(o + "page.html", "<!DOCTYPE html><pre>&lt;robot name</pre>", option), any);
    EXPECT_FALSE(refused(o + "empty", "", option));
  }
}

TEST_F(FilesOfARun, ThatAreItsInputsAreRefusedEvenWithForce) {
  permit_replacing_specs();
  note_input(file("spec.yaml"));
  EXPECT_NE(refusal([&] { note_output(file("spec.yaml"), "--write-spec"); }), "");
}

TEST_F(FilesOfARun, ReplaceASpecThatIsAsItWasWritten) {
  std::ofstream(file("s.yaml")) << "qerr: 1\n";
  note_as_written(file("s.yaml"));
  std::ofstream(file("edited.yaml")) << "qerr: 1\n";
  note_as_written(file("edited.yaml"));
  std::ofstream(file("edited.yaml"), std::ios::app) << "# edited\n";
  EXPECT_NE(refusal([&] { note_output(file("edited.yaml"), "--write-spec"); }), "");
  std::ofstream(file("as_written.yaml")) << "qerr: 1\n";
  note_as_written(file("as_written.yaml"));
  EXPECT_NE(refusal([&] { note_output(file("s.yaml"), "--output"); }), "");
  char sum[64];
  const bool has_notes = getxattr(file("as_written.yaml").c_str(), "user.qerr.written", sum, sizeof sum) > 0;
  EXPECT_EQ(refusal([&] { note_output(file("as_written.yaml"), "--write-spec"); }) == "", has_notes);
}

TEST_F(FilesOfARun, RefuseTwoOutputsThatAreOneFile) {
  note_output(file("new.csv"));
  EXPECT_NE(refusal([&] { note_output(file("./new.csv")); }), "") << "of a file that does not exist yet";
  note_output(file("spec.yaml"));
  EXPECT_NE(refusal([&] { note_output(file("spec.yaml")); }), "");
  EXPECT_EQ(refusal([&] { note_output(file("other.csv")); }), "");
  std::filesystem::create_symlink("missing.csv", file("link.csv"));
  note_output(file("link.csv"));
  EXPECT_NE(refusal([&] { note_output(file("missing.csv")); }), "") << "behind a link";
}

TEST_F(FilesOfARun, LeaveStandardOutputToOneResult) {
  note_output("-");
  EXPECT_NE(refusal([] { note_output("-"); }).find("standard output"), std::string::npos);
}

TEST_F(FilesOfARun, MayReadAndWriteDevices) {
  note_input("/dev/null");
  EXPECT_EQ(refusal([] { note_output("/dev/null"); }), "");
  EXPECT_EQ(refusal([] { note_output("/dev/null"); }), "");
}

TEST_F(FilesOfARun, MayBeReadTwice) {
  note_input(file("spec.yaml"));
  EXPECT_EQ(refusal([&] { note_input(file("spec.yaml")); }), "");
}

TEST(FilesWithoutARun, AreFree) {
  const auto path =
      (std::filesystem::temp_directory_path() / ("qerr_free_" + std::to_string(getpid()))).string();
  note_output(path);
  EXPECT_NO_THROW(note_output(path));
  EXPECT_NO_THROW(note_input(path));
}

}  // namespace
}  // namespace qerr
