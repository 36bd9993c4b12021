#include "report/sweep/sweep.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "qerr/core/error.hpp"

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

  static std::string lines(std::uint64_t i) {
    const std::string cells = std::to_string(i) + ",v" + std::to_string(i) + ',';
    return cells + "first\r\n" + cells + "second\r\n";
  }

  std::string text() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void set(const std::string& text) const {
    std::filesystem::remove(path_);  // and with it the note of the file
    std::ofstream(path_, std::ios::binary) << text;
  }
  /// The same file with other bytes: its note stays.
  void overwrite(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }

  std::string mark() const { return shard_mark({}, record_); }
  std::string header() const { return columns + (marked_ ? ',' + mark() : std::string()); }

  ShardFile opened(bool keep) const { return {path_, "--output", header(), record_, marked_, keep}; }

  /// @returns the variants that were kept
  std::uint64_t resumed(std::uint64_t variants) const {
    ShardFile file(path_, "--output", header(), record_, marked_, true);
    SweepCounts counts = file.resume(false);
    const std::uint64_t kept = counts.variants;
    while (counts.variants < variants) {
      const std::string own = lines(counts.variants);
      count_verdict(counts, 'u');
      file.write(marked_ ? marked_lines(own, 'u', mark()) : own, counts);
    }
    file.close();
    return kept;
  }

  static constexpr std::uint64_t count = 6;
  static constexpr const char* columns = "variant,key,value";
  std::filesystem::path path_;
  RunRecord record_{"spec=1; catalogue e.csv=2"};
  bool marked_ = false;
};

TEST_F(ShardFileTest, ResumesFromEveryLength) {
  for (const bool marked : {false, true}) {
    marked_ = marked;
    set("");
    ASSERT_EQ(resumed(count), 0u);
    const std::string whole = text();
    for (std::size_t size = 0; size <= whole.size(); size += marked ? 7 : 2) {
      set(whole.substr(0, size));
      const std::uint64_t kept = resumed(count);
      EXPECT_EQ(text(), whole) << size;
      const auto seen = static_cast<std::uint64_t>(
          std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size), '\n'));
      if (marked) {
        EXPECT_GE(kept + 1, seen / 2) << size;
      }
    }
  }
}

TEST_F(ShardFileTest, ANoteKeepsWhatWasWritten) {
  resumed(count);
  const std::string whole = text();
  const bool noted = resumed(count) == count;  // not every file system has notes
  overwrite(whole.substr(0, whole.size() / 2));
  EXPECT_EQ(resumed(count), 0u);
  EXPECT_EQ(text(), whole);
  std::string changed = whole;
  changed.replace(changed.find("second"), 6, "other!");
  overwrite(changed);
  if (noted) {
    EXPECT_EQ(resumed(count), 0u);
    EXPECT_EQ(text(), whole);
  }
  record_ = RunRecord("spec=1; catalogue e.csv=3");
  try {
    resumed(count);
    EXPECT_FALSE(noted);
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("the catalogue e.csv"), std::string::npos) << e.what();
    EXPECT_EQ(text(), whole);
  }
}

TEST_F(ShardFileTest, ComputesAChangedVariantOfAShardAnew) {
  marked_ = true;
  resumed(count);
  const std::string whole = text();
  const std::size_t third = whole.find("3,v3"), end = whole.find("\r\n", third);
  for (const std::string& damaged :
       {whole.substr(0, end) + ",more" + whole.substr(end),
        whole.substr(0, end) + '\0' + whole.substr(end + 1), whole.substr(0, end + 2) + whole.substr(third),
        whole.substr(0, third) + '4' + whole.substr(third + 1)}) {
    set(damaged);
    EXPECT_LE(resumed(count), 3u);
    EXPECT_EQ(text(), whole) << damaged;
  }
}

TEST_F(ShardFileTest, OnlyACompleteFileEndsWithALineBreak) {
  {
    ShardFile file = opened(false);
    for (std::uint64_t i = 0; i < count; ++i) {
      file.write(lines(i), {i + 1});
      EXPECT_FALSE(text().ends_with('\n'));
    }
    file.close();
  }
  EXPECT_TRUE(text().ends_with('\n'));
  ShardFile empty = opened(false);
  empty.close();
  EXPECT_EQ(text(), std::string(columns) + "\r\n");
}

TEST_F(ShardFileTest, ComputesRowsWithoutANoteAnew) {
  resumed(count);
  const std::string whole = text();
  std::string changed = whole;
  changed.replace(changed.find("second"), 6, "other!");
  for (const std::string& content : {whole, changed}) {
    set(content);
    ShardFile file = opened(true);
    EXPECT_EQ(file.resume(false).variants, 0u);
    EXPECT_TRUE(file.unknown());
  }
  set(changed);
  EXPECT_EQ(resumed(count), 0u);
  EXPECT_EQ(text(), whole);
}

TEST_F(ShardFileTest, RefusesFilesOfOtherColumns) {
  resumed(count);
  const std::string whole = text();
  for (const bool marked : {false, true}) {
    marked_ = marked;
    for (const std::string& content : {"variant,key\r\n" + whole.substr(whole.find('\n') + 1),
                                       std::string("something else"), std::string("root:secret:0\r\n")}) {
      set(content);
      try {
        resumed(count);
        FAIL() << content;
      } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find("secret"), std::string::npos) << e.what();
      }
      EXPECT_EQ(text(), content);
    }
  }
}

TEST(RunRecord, NamesWhatDiffers) {
  const RunRecord a("URDF arm.urdf=1; catalogue e.csv=2; spec=3; variants=8");
  EXPECT_EQ(RunRecord(a.text()).difference(a), "");
  EXPECT_EQ(a.difference(RunRecord("URDF arm.urdf=1; catalogue e.csv=9; spec=4; variants=7")),
            "the catalogue e.csv, the spec");
  EXPECT_EQ(a.difference(RunRecord("URDF arm.urdf=1; catalogue e.csv=2; option --set=5; spec=3; variants=8")),
            "the option --set");
  EXPECT_EQ(a.value("variants"), "8");
}

TEST(SweepGrid, NumbersHaveOneUnitAndOthersAreTexts) {
  Spec spec;
  const auto axis = [](const std::string& key, const std::vector<std::string>& values) {
    SweepAxis a{{key}, {}};
    for (const std::string& value : values) a.steps.push_back({{value}, {{key, value}}, {}});
    return a;
  };
  spec.sweep = {axis("a", {"5 Hz", "1 kHz"}),
                axis("b", {"90 deg", "2"}),
                axis("c", {"5 Hz", "1 mm"}),
                axis("d", {"first_order"}),
                axis("e", {"1/100", "20 %"}),
                axis("filters.v.lowpass.cutoff", {"5", "9"}),
                {{"f"}, {{{"12"}, {{"f", "{bits: 3}"}}, {}}}}};
  const SweepGrid grid(spec);
  const auto& columns = grid.columns();
  std::vector<std::string> headers;
  for (const SweepColumn& column : columns) headers.push_back(column.header());
  EXPECT_EQ(headers, (std::vector<std::string>{"a [Hz]", "b [rad]", "c", "d", "e",
                                               "filters.v.lowpass.cutoff [Hz]", "f"}));
  EXPECT_EQ(columns[0].values, (std::vector<double>{5, 1000}));
  EXPECT_NEAR(columns[1].values[0], std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(columns[4].values, (std::vector<double>{0.01, 0.2}));
  for (const std::size_t text : {2u, 3u, 6u}) EXPECT_TRUE(columns[text].values.empty()) << text;
}

TEST_F(ShardFileTest, AFileThatIsBeingWrittenIsNotOpenedAgain) {
  ShardFile file = opened(false);
  EXPECT_THROW(opened(true), Error);
}

}  // namespace
}  // namespace qerr
