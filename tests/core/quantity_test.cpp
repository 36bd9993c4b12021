#include "qerr/core/quantity.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <locale>
#include <numbers>
#include <set>

#include "core/output_file.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/sha256.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/unit.hpp"

namespace qerr {
namespace {

constexpr double pi = std::numbers::pi;

std::optional<Quantity> quantity(std::string_view text) {
  std::string why;
  return parse_quantity(text, why);
}

TEST(Quantity, ReadsTheUnitsOfTheContract) {
  const struct {
    const char* text;
    double value;
    Dimension dimension;
  } cases[] = {{"50 Hz", 50, dimension::frequency},
               {"1 kHz", 1e3, dimension::frequency},
               {"0.1 mm", 1e-4, dimension::length},
               {"10 um", 1e-5, dimension::length},
               {"10µm", 1e-5, dimension::length},
               {"15 deg", 15 * pi / 180, dimension::angle},
               {"0.125 mrad", 1.25e-4, dimension::angle},
               {"2 ms", 2e-3, dimension::time},
               {"5 mm/s", 5e-3, dimension::speed},
               {"12 arcmin", 12 * pi / 10800, dimension::angle},
               {"-3e-2 rad/s", -0.03, dimension::angular_speed},
               {"2 N m", 2, dimension::torque},
               {"3 urad/(N m)", 3e-6, dimension::compliance},
               {"1 rev", 2 * pi, dimension::angle},
               {"60 rpm", 2 * pi, dimension::angular_speed},
               {"4 in", 0.1016, dimension::length}};
  for (const auto& c : cases) {
    const auto q = quantity(c.text);
    ASSERT_TRUE(q) << c.text;
    EXPECT_NEAR(q->value, c.value, 1e-15 * std::abs(c.value)) << c.text;
    EXPECT_EQ(q->dimension, c.dimension) << c.text;
  }
  EXPECT_EQ(quantity("2 m/s^2")->dimension, (Dimension{1, 0, -2}));
  EXPECT_FALSE(quantity("7")->dimension);
  EXPECT_EQ(quantity("30 um")->value, 3e-5);
  EXPECT_EQ(quantity("0.3 mm/s")->value, 3e-4);
}

TEST(Quantity, RefusesWhatIsNotAPlainDecimalNumberWithAKnownUnit) {
  for (const char* text : {"",      " ",      "nan", ".nan",  "inf", "-.inf",           "1e400", "1e-400",
                           "0x1F",  "010",    "1,5", "1.2.3", "--1", "5 parsec",        "5 mm/", "5 (mm",
                           "5 mm)", "5 mm^0", "mm",  "e5",    "5e",  "1e-200 nm/1e-200"})
    EXPECT_FALSE(quantity(text)) << text;
}

TEST(Quantity, NamesUnitsSoThatTheyReadBack) {
  for (const Dimension& d :
       {dimension::length, dimension::angle, dimension::speed, dimension::compliance, dimension::torque,
        Dimension{1, 0, -2}, Dimension{0, 1, -3}, dimension::frequency, dimension::angle_per_temperature})
    EXPECT_EQ(quantity("1 " + unit_name(d))->dimension, d) << unit_name(d);
}

TEST(Unit, AloneIsWhatItIsBehindANumber) {
  for (const std::string unit : {"mrad", "um/s", "N m", "deg", "degC", "1", "%", "rad/(N m)", "ms"}) {
    std::string why;
    const auto alone = parse_unit(unit, why);
    ASSERT_TRUE(alone) << unit << why;
    EXPECT_EQ(alone->in_si(0.3), quantity("0.3 " + unit)->value) << unit;
    EXPECT_EQ(alone->dimension, quantity("0.3 " + unit)->dimension) << unit;
  }
  for (const std::string unit : {"", " ", "5", "m/", "furlong", "[m]"}) {
    std::string why;
    EXPECT_FALSE(parse_unit(unit, why)) << unit;
    EXPECT_NE(why, "") << unit;
  }
}

TEST(Number, IsTheSameInEveryLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  EXPECT_EQ(parse_number("12.5"), 12.5);
  EXPECT_EQ(shortest(12.5), "12.5");
  std::locale::global(before);
}

TEST(Number, ShortestReadsBackAsTheSameDouble) {
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double value = std::ldexp(unit_interval(random_bits(7, i, 0)) - 0.5,
                                    static_cast<int>(random_bits(7, i, 1) % 200) - 100);
    EXPECT_EQ(parse_number(shortest(value)), value);
  }
}

TEST(Sha256, GivesTheVectorsOfFips180) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Suggest, FindsWhatWasMeantAndNothingFarAway) {
  const std::vector<std::string> known{"counts_per_rev", "lines_per_rev", "bits", "resolution"};
  EXPECT_EQ(nearest("count_per_rev", known), "counts_per_rev");
  EXPECT_EQ(nearest("Bits", known), "bits");
  EXPECT_EQ(nearest("resoltuion", known), "resolution");
  EXPECT_EQ(nearest("colour", known), "");
}

TEST(Utf8, TakesWellFormedTextAndNothingElse) {
  for (const std::string good : {"a", "é", "€", "😀"}) EXPECT_EQ(utf8_length(good, 0), good.size());
  for (const std::string bad :
       {"\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF0\x9F\x98", "\x80", "\xFF"})
    EXPECT_EQ(utf8_length(bad, 0), 0u);
}

TEST(Message, IsOneLineWithPlaceRuleFoundAndRemedyAndNoControlCharacters) {
  const std::string text =
      format({{{"a.yaml", 3, 7}, "encoders.x", "unknown key", "'b\x1b[2Jit\n'", "did you mean 'bits'?"}});
  EXPECT_EQ(text, "a.yaml:3:7: encoders.x: unknown key, found 'b\\x1B[2Jit\\x0A'; did you mean 'bits'?");
}

TEST(Message, HasAtMostTwentyLines) {
  const std::string text = format(std::vector<Fault>(100, {{"f", 1, 1}, "k", "r", "", ""}));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 19);
  EXPECT_NE(text.find("(81 more faults)"), std::string::npos);
}

TEST(Parallel, RunsEveryTaskOnceAndRethrows) {
  for (const unsigned threads : {1u, 2u, 7u}) {
    std::vector<int> done(1000);
    parallel_for(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    EXPECT_EQ(done, std::vector<int>(1000, 1));
  }
  EXPECT_THROW(parallel_for(100, 3,
                            [](std::size_t i) {
                              if (i == 57) throw std::runtime_error("57");
                            }),
               std::runtime_error);
}

class OutputFiles : public testing::Test {
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

TEST_F(OutputFiles, AppearsWholeAtCloseAndNotBefore) {
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

TEST_F(OutputFiles, LeavesTheOldFileAndNoTemporaryWhenItIsAbandoned) {
  const auto path = folder_ / "a.json";
  std::ofstream(path) << "old";
  { OutputFile(path.string()).write("half"); }
  EXPECT_EQ(read(path), "old");
  EXPECT_EQ(files(), 1u);
}

TEST_F(OutputFiles, WritesThroughALinkAndIntoAPipeWithoutReplacingThem) {
  std::ofstream(folder_ / "real.txt") << "old";
  std::filesystem::create_symlink("real.txt", folder_ / "link.txt");
  OutputFile out((folder_ / "link.txt").string());
  out.write("new");
  out.close();
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(read(folder_ / "real.txt"), "new");
}

TEST_F(OutputFiles, SaysSoBeforeTheWorkWhenItCannotBeWritten) {
  try {
    OutputFile out((folder_ / "missing" / "a.json").string());
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::file_system);
    EXPECT_NE(std::string(e.what()).find("missing"), std::string::npos);
  }
}

TEST_F(OutputFiles, ReportsAFullDevice) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  OutputFile out("/dev/full");
  out.write("x");
  EXPECT_THROW(out.close(), Error);
}

}  // namespace
}  // namespace qerr
