#include "input/read_text.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

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
