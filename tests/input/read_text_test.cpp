#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/run_files.hpp"
#include "input/csv.hpp"
#include "qerr/core/error.hpp"

namespace qerr {
namespace {

TEST(ReadText, RejectsUnreadableFiles) {
  for (const std::string path : {"/", "/nonexistent/r.urdf", "/dev/null", ""}) {
    try {
      read_text(path);
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::file_system) << e.what();
    }
  }
}

TEST(ReadText, RejectsAFileThatBecomesShorterWhileItIsRead) {
  const auto path =
      std::filesystem::temp_directory_path() / ("qerr_shorter_" + std::to_string(std::rand()) + ".csv");
  std::ofstream(path) << std::string(1000, 'x');
  ByteSource source(path.string());
  char some[100];
  EXPECT_EQ(source.read(some, sizeof some), 100u);
  std::filesystem::resize_file(path, 100);
  try {
    source.read(some, sizeof some);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::file_system);
  }
  std::filesystem::remove(path);
}

/// As behind `head` in a shell's brackets.
TEST(ReadText, TakesStandardInputFromWhereItStands) {
  const auto path = std::filesystem::temp_directory_path() / ("qerr_within_" + std::to_string(std::rand()));
  std::ofstream(path) << "first\nsecond\n";
  const int old = dup(STDIN_FILENO), file = open(path.c_str(), O_RDONLY);
  ASSERT_EQ(dup2(file, STDIN_FILENO), STDIN_FILENO);
  lseek(STDIN_FILENO, 6, SEEK_SET);
  EXPECT_EQ(read_text("-"), "second\n");
  dup2(old, STDIN_FILENO);
  close(old);
  close(file);
  std::filesystem::remove(path);
}

/// `--set robot.urdf=<(xacro ...)` of a spec that is read several times.
TEST(ReadText, KeepsWhatAPipeGaveForTheRun) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("qerr_pipe_" + std::to_string(std::rand()))).string();
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(path) << "once"; });
  const RunFiles run;
  EXPECT_EQ(read_text(path), "once");
  writer.join();
  EXPECT_EQ(read_text(path), "once");
  std::filesystem::remove(path);
}

TEST(ReadText, DropsAByteOrderMarkAndRejectsBadBytesAndHugeFiles) {
  const auto path =
      std::filesystem::temp_directory_path() / ("qerr_read_text_" + std::to_string(std::rand()));
  const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
  write("\xEF\xBB\xBFhello\n");
  EXPECT_EQ(read_text(path.string()), "hello\n");
  write("");
  EXPECT_EQ(read_text(path.string()), "");
  write("one\n\xC3\xA9\xC3(");
  try {
    read_text(path.string());
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::input);
    EXPECT_EQ(e.faults()[0].place.line, 2);
    EXPECT_EQ(e.faults()[0].place.column, 2);
  }
  write(std::string(16'000'001, 'x'));
  EXPECT_THROW(read_text(path.string()), Error);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace qerr
