#include "core/output_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "qerr/core/error.hpp"

namespace qerr {
namespace {

class OutputFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_output_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string read(const std::filesystem::path& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t files() {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }
  std::filesystem::path folder_;
};

TEST_F(OutputFiles, ReplaceTheOldFileCompletelyAtClose) {
  const auto path = folder_ / "a.json";
  std::ofstream(path) << "old";
  {
    OutputFile out(path.string());
    out.write("new");
    EXPECT_EQ(read(path), "old");
    out.close();
    EXPECT_EQ(read(path), "new");
  }
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFiles, KeepTheOldFileAndLeaveNoTemporaryIfNotClosed) {
  const auto path = folder_ / "a.json";
  std::ofstream(path) << "old";
  { OutputFile(path.string()).write("half"); }
  EXPECT_EQ(read(path), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFiles, WriteThroughALinkWithoutReplacingIt) {
  std::ofstream(folder_ / "real.txt") << "old";
  std::filesystem::create_symlink("real.txt", folder_ / "link.txt");
  OutputFile out((folder_ / "link.txt").string());
  out.write("new");
  out.close();
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(read(folder_ / "real.txt"), "new");
}

TEST_F(OutputFiles, WriteThroughALinkToAFileThatIsMissing) {
  std::filesystem::create_symlink("missing.txt", folder_ / "link.txt");
  std::filesystem::create_symlink(folder_ / "link.txt", folder_ / "link_of_link.txt");
  OutputFile out((folder_ / "link_of_link.txt").string());
  out.write("new");
  out.close();
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.txt"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link_of_link.txt"));
  EXPECT_EQ(read(folder_ / "missing.txt"), "new");
}

TEST_F(OutputFiles, AreReadableByThoseWhoMayReadTheOldFile) {
  using std::filesystem::perms;
  for (const perms mode :
       {perms::owner_read | perms::owner_write, perms::owner_all | perms::group_read | perms::others_read}) {
    const auto path = folder_ / "private.json";
    std::ofstream(path) << "old";
    std::filesystem::permissions(path, mode);
    OutputFile out(path.string());
    out.write("new");
    out.close();
    EXPECT_EQ(read(path), "new");
    EXPECT_EQ(std::filesystem::status(path).permissions(), mode);
  }
}

TEST_F(OutputFiles, AreRejectedIfTheirLinksGoInACircle) {
  std::filesystem::create_symlink("b.txt", folder_ / "a.txt");
  std::filesystem::create_symlink("a.txt", folder_ / "b.txt");
  EXPECT_THROW(OutputFile((folder_ / "a.txt").string()), Error);
}

TEST_F(OutputFiles, AreRejectedAtTheStartIfTheyCannotBeWritten) {
  try {
    OutputFile out((folder_ / "missing" / "a.json").string());
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::file_system);
    EXPECT_NE(std::string(e.what()).find("missing"), std::string::npos);
  }
}

TEST_F(OutputFiles, HaveNoNameUntilTheyAreWhole) {
  OutputFile out((folder_ / "a.json").string());
  out.write("new");
  // Where the file system has no files without a name, the temporary file does not stop another run.
  EXPECT_LE(files(), 1u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.json"));
  out.close();
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFiles, ReplaceAFileThatAppearsWhileTheyAreWritten) {
  OutputFile out((folder_ / "a.json").string());
  std::ofstream(folder_ / "a.json") << "of another process";
  out.write("new");
  out.close();
  EXPECT_EQ(read(folder_ / "a.json"), "new");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFiles, AreRejectedAtTheStartIfTheirNameIsTooLong) {
  EXPECT_THROW(OutputFile((folder_ / std::string(300, 'a')).string()), Error);
}

TEST_F(OutputFiles, ReportAFullDevice) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  OutputFile out("/dev/full");
  out.write("x");
  EXPECT_THROW(out.close(), Error);
}

}  // namespace
}  // namespace qerr
