#include "report/text_table.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {
namespace {

TEST(TextTable, WritesFractionsInPercentWithThreeDigits) {
  EXPECT_EQ(percent(0.1234), "12.3 %");
  EXPECT_EQ(percent(-0.05), "-5 %");
  EXPECT_EQ(percent(0), "0 %");
  EXPECT_EQ(percent(9.999), "1000 %");
  EXPECT_EQ(percent(12.345), "1234 %");
  EXPECT_EQ(percent(1e-6), "<0.001 %");
  EXPECT_EQ(percent(101), ">10000 %");
  EXPECT_EQ(percent(std::numeric_limits<double>::quiet_NaN()), "");
}

TEST(TextTable, AlignsNumbersToTheRight) {
  EXPECT_EQ(aligned({{"", "max"}, {"x", "1 um"}}), "      max\n  x  1 um\n");
}

TEST(TextTable, HasCodesOnlyInAStyleWithColours) {
  EXPECT_EQ(painted("a", Paint::red, {}), "a");
  EXPECT_EQ(painted("a", Paint::red, {.color = true}), "\x1b[1;31ma\x1b[0m");
}

TEST(Formats, AreChosenByTheEndingOfAFile) {
  EXPECT_EQ(format_of("figures.csv"), "csv");
  EXPECT_EQ(format_of("a.json"), "json");
  EXPECT_EQ(format_of("-"), "table");
  EXPECT_EQ(format_of("a.txt"), "table");
}

TEST(Formats, RefuseAnUnknownName) { EXPECT_THROW(write(ThresholdReport{}, "xml"), Error); }

TEST(Formats, WriteEveryFamilyThatCanBeListed) {
  for (const std::string& kind : list_kinds()) {
    const ListReport report = list_report(kind);
    EXPECT_FALSE(report.rows.empty()) << kind;
    for (const Format& format : formats())
      if (format.name == "html" || format.name == "md")  // the page and the summary of other commands
        EXPECT_THROW(write(report, format.name), Error);
      else
        EXPECT_FALSE(write(report, format.name).empty()) << kind;
  }
}

}  // namespace
}  // namespace qerr
