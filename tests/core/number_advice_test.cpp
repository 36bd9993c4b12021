#include <gtest/gtest.h>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {
namespace {

TEST(NumberAdvice, SaysHowToWriteWhatPeopleWrite) {
  const struct {
    const char *text, *remedy;
  } cases[] = {
      {"0,02 deg", "write 0.02 deg"},
      {"1.000,5", "write 1000.5"},
      {"1,000.5", "write 1000.5"},
      {"1,000,000", "write 1000000"},
      {"1,000", "write 1000 or 1.000"},
      {"4 096", "write 4096"},
      {"4'096", "write 4096"},
      {"4_096 counts", "write 4096 counts"},
      {"100:1", "write 100/1"},
      {"1:100", "write 1/100"},
      {"\u22125 deg", "write -5 deg"},
      {"5\u00A0mm", "write 5 mm"},
      {"20\u2033", "write 20 arcsec"},
      {"20\"", "write 20 arcsec"},
      {"2 m/s\u00B2", "write 2 m/s^2"},
      {"\u00B110 um", "write 10 um"},
      {"100x", "write 100"},
      {"15 degrees", "write 15 deg"},
      {"15deg.", "write 15 deg"},
      {"3 microns", "write 3 um"},
      {"50 hz", "write 50 Hz"},
      {"1 KHz", "write 1 kHz"},
      {"10 degrees/s", "write 10 deg/s"},
      {"0.1 rad/sec", "write 0.1 rad/s"},
      {"0.1 GHz", ""},  // 0.1 Hz is not meant
      {"010", "write 10"},
      {"2**pi", "write its value"},
      {"2^12", "write its value"},
      {"4 x 1024", "write its value"},
      {"4k", "write 4e3"},
      {"< 1 mm", "write 1 mm"},
  };
  for (const auto& c : cases) {
    std::string why;
    ASSERT_FALSE(parse_quantity(c.text, why)) << c.text;
    const NumberAdvice advice = advice_on_number(c.text, why);
    EXPECT_EQ(advice.remedy, c.remedy) << c.text;
    EXPECT_NE(advice.rule, "") << c.text;
  }
}

TEST(NumberAdvice, OffersOnlyTextThatReadsBack) {
  for (const char* text : {"5 parsec", "abc", "1e400", ",", "1,,2", "--1", "5 mm^0", "", "'", "1:2:3:4"}) {
    std::string why;
    ASSERT_FALSE(parse_quantity(text, why)) << text;
    const std::string remedy = advice_on_number(text, why).remedy;
    if (remedy.starts_with("write ") && remedy != "write its value") {
      EXPECT_TRUE(parse_quantity(remedy.substr(6), why)) << text << ": " << remedy;
    }
  }
}

}  // namespace
}  // namespace qerr
