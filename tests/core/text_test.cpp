#include "core/text.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <limits>
#include <string>

namespace qerr {
namespace {

TEST(Utf8, AcceptsWellFormedTextOnly) {
  for (const std::string good : {"a", "é", "€", "😀"}) EXPECT_EQ(utf8_length(good, 0), good.size());
  for (const std::string bad :
       {"\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF0\x9F\x98", "\x80", "\xFF"})
    EXPECT_EQ(utf8_length(bad, 0), 0u);
}

TEST(HiddenCharacters, AreThoseThatNobodySees) {
  for (const std::string hidden : {"\x1b", "\x7f", "\u0085", "\u009b", "\u200b", "\u200f", "\u202e", "\u2066",
                                   "\ufeff", "\u2028", "\U000e0041"})
    EXPECT_EQ(hidden_length(hidden, 0), hidden.size());
  for (const std::string seen : {" ", "a", "é", "°", "µ", "€", "関", "😀"})
    EXPECT_EQ(hidden_length(seen, 0), 0u);
  EXPECT_EQ(hidden_length("\xFF", 0), 1u);
}

TEST(NumberText, IsThatOfTheCLocaleInEveryLocale) {
  const char* const before = std::setlocale(LC_NUMERIC, nullptr);
  const std::string previous = before ? before : "C";
  for (const char* name :
       {"de_DE.UTF-8", "fr_FR.UTF-8", "C"}) {  // those that are not installed keep the last one
    std::setlocale(LC_NUMERIC, name);
    EXPECT_EQ(significant(0.0012345, 3), "0.00123");
    EXPECT_EQ(significant(1e-6, 3), "1e-06");
    EXPECT_EQ(fixed_point(2.345, 1), "2.3");
    EXPECT_EQ(readable(1e-6, "m"), "1.00 um");
    EXPECT_EQ(rounded_to(1234.5, 3), 1230);
  }
  std::setlocale(LC_NUMERIC, previous.c_str());
}

TEST(NumberText, NamesInfinityAndNan) {
  EXPECT_EQ(readable(std::numeric_limits<double>::infinity(), "m"), "unbounded");
  EXPECT_EQ(readable(std::numeric_limits<double>::quiet_NaN(), "m"), "not known");
  EXPECT_EQ(readable(999.96e-6, "m"), "1.00 mm");
  EXPECT_EQ(readable(0.132, ""), "0.132") << "132 m would be metres";
}

}  // namespace
}  // namespace qerr
