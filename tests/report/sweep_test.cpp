#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "qerr/core/error.hpp"
#include "report/sweep/csv_lines.hpp"
#include "report/sweep/grid.hpp"
#include "report/sweep/merge.hpp"
#include "report/sweep/shard_file.hpp"

namespace qerr {
namespace {

TEST(Shard, AllShardsHaveEveryVariantOnce) {
  for (const std::uint64_t total : {0u, 1u, 7u, 20u})
    for (const std::uint64_t shards : {1u, 2u, 5u, 30u}) {
      std::vector<int> seen(total);
      for (std::uint64_t k = 0; k < shards; ++k) {
        const Shard shard{k, shards};
        for (std::uint64_t i = 0; i < shard.size(total); ++i) ++seen.at(shard.variant(i));
      }
      EXPECT_EQ(seen, std::vector<int>(total, 1)) << total << ' ' << shards;
    }
}

TEST(SweepGrid, TheFirstAxisVariesSlowest) {
  Spec spec;
  spec.sweep = {{{"a", "b"}, {{{"1", "2"}, {{"a", "1"}, {"b", "2"}}, {}}, {{"3", "4"}, {}, {}}}},
                {{"c"}, {{{"x"}, {}, {}}, {{"y"}, {}, {}}, {{"z"}, {}, {}}}}};
  const SweepGrid grid(spec);
  ASSERT_EQ(grid.count(), 6u);
  EXPECT_EQ(grid.keys(), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(grid.names(0), (std::vector<std::string>{"1", "2", "x"}));
  EXPECT_EQ(grid.names(2), (std::vector<std::string>{"1", "2", "z"}));
  EXPECT_EQ(grid.names(3), (std::vector<std::string>{"3", "4", "x"}));
  EXPECT_EQ(grid.description(5), "a = 3, b = 4, c = z");
}

TEST(CsvLines, AreThoseOfTheTextHoweverItIsRead) {
  const std::string text = "variant,x\r\n0,a\r\n\r\n1,b\nc\r\n2,torn\r";
  for (const std::size_t piece : {1u, 2u, 3u, 100u}) {
    CsvLines lines([&](std::uint64_t from, std::size_t) {
      return from < text.size() ? text.substr(from, piece) : std::string();
    });
    std::vector<std::string> found;
    std::vector<std::uint64_t> begins;
    while (lines.next()) {
      found.emplace_back(lines.line());
      begins.push_back(lines.begin());
      EXPECT_EQ(lines.ended(), found.size() < 5);
    }
    EXPECT_EQ(found, (std::vector<std::string>{"variant,x", "0,a", "", "1,b\nc", "2,torn\r"})) << piece;
    EXPECT_EQ(begins, (std::vector<std::uint64_t>{0, 11, 16, 18, 25}));
  }
}

class ShardFileTest : public ::testing::Test {
 protected:
  ShardFileTest() {
    path_ = std::filesystem::temp_directory_path() / ("qerr_shard_" + std::to_string(getpid()) + ".csv");
  }
  ~ShardFileTest() override { std::filesystem::remove(path_); }

  static std::string cells(std::uint64_t i) { return std::to_string(i) + ",v" + std::to_string(i) + ','; }
  static std::string lines(std::uint64_t i) { return cells(i) + "first\r\n" + cells(i) + "second\r\n"; }

  std::string text() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void set(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }

  std::uint64_t resumed(std::uint64_t count) const {
    ShardFile file(path_, "--output", "variant,key,value", true);
    const std::uint64_t begin = file.resume(count, cells, lines);
    for (std::uint64_t i = begin; i < count; ++i) file.write(lines(i));
    file.close();
    return begin;
  }

  static constexpr std::uint64_t count = 6;
  std::filesystem::path path_;
};

TEST_F(ShardFileTest, ResumesFromEveryLength) {
  ASSERT_EQ(resumed(count), 0u);
  const std::string whole = text();
  EXPECT_TRUE(whole.ends_with(lines(count - 1)));
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    set(whole.substr(0, size));
    const std::uint64_t begin = resumed(count);
    EXPECT_EQ(text(), whole) << size;
    // Of what stands there, only the last variant is computed again.
    const auto seen = static_cast<std::uint64_t>(
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size), '\n'));
    EXPECT_GE(begin + 2, seen / 2) << size;
  }
}

TEST_F(ShardFileTest, ResumesBeforeADamagedLine) {
  resumed(count);
  const std::string whole = text();
  const std::size_t third = whole.find("3,v3"), end = whole.find("\r\n", third);
  for (const std::string& damaged : {whole.substr(0, end) + ",more" + whole.substr(end),
                                     whole.substr(0, end) + "\xe2\x80\xae" + whole.substr(end),
                                     whole.substr(0, end) + '\0' + whole.substr(end + 1),
                                     whole.substr(0, end + 2) + whole.substr(third)}) {
    set(damaged);
    EXPECT_LE(resumed(count), 3u);
    EXPECT_EQ(text(), whole) << damaged;
  }
}

TEST_F(ShardFileTest, OnlyACompleteFileEndsWithALineBreak) {
  {
    ShardFile file(path_, "--output", "variant,key,value", false);
    for (std::uint64_t i = 0; i < count; ++i) {
      file.write(lines(i));
      EXPECT_FALSE(text().ends_with('\n'));
    }
    file.close();
  }
  EXPECT_TRUE(text().ends_with('\n'));
  ShardFile empty(path_, "--output", "variant,key,value", false);
  empty.close();
  EXPECT_EQ(text(), "variant,key,value\r\n");
}

TEST_F(ShardFileTest, RefusesFilesThatAreNotItsBegin) {
  resumed(count);
  const std::string whole = text();
  const auto refused = [&](const std::string& content, std::uint64_t variants) {
    set(content);
    EXPECT_THROW(resumed(variants), Error) << content;
    EXPECT_EQ(text(), content);
  };
  refused(whole, count - 1);
  refused("variant,key\r\n" + whole.substr(whole.find('\n') + 1), count);
  refused("something else", count);
  set("root:secret:0\r\n");
  try {
    resumed(count);
    FAIL() << "a foreign file";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find("secret"), std::string::npos) << e.what();
  }
  std::string changed = whole;
  changed.replace(changed.find("second"), 6, "other!");
  refused(changed, count);  // the first variant has other figures
  changed = whole;
  changed.replace(changed.find("3,v3"), 4, "3,v4");
  refused(changed, count);
}

TEST_F(ShardFileTest, AFileThatIsBeingWrittenIsNotOpenedAgain) {
  ShardFile file(path_, "--output", "variant,key,value", false);
  EXPECT_THROW(ShardFile(path_, "--output", "variant,key,value", true), Error);
}

}  // namespace
}  // namespace qerr
