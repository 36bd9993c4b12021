#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr {
namespace {

std::size_t widest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t widest = 0;
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, display_width(line));
  return widest;
}

const std::vector<std::vector<std::string>> figures{
    {"filter", "equivalent noise bandwidth", "settling to 2 %", "tracking error"},
    {"velocity", "66.0 Hz", "19.0 ms", "18.4 %"},
    {"acceleration", "61.6 Hz", "24.0 ms", "9.29 %"}};

TEST(WrappedText, KeepsEveryWordAndTheWidth) {
  EXPECT_EQ(wrapped("one two  three\nfour", 9), "one two\nthree\nfour\n");
  EXPECT_EQ(wrapped("one two three", 9, "    ", "  - "), "  - one\n    two\n    three\n");
  EXPECT_EQ(wrapped("incomprehensible", 5), "incomprehensible\n");
  EXPECT_EQ(wrapped("\u00b5m \u00b5m", 5), "\u00b5m \u00b5m\n") << "columns, not bytes";
}

TEST(WrappedText, CutsLongWordsWhereItMay) {
  EXPECT_EQ(wrapped("a incomprehensible b", 7, "", "", LongWords::cut), "a\nincompr\nehensib\nle b\n");
  EXPECT_EQ(wrapped("\u00b5\u00b5\u00b5\u00b5", 3, "", "", LongWords::cut), "\u00b5\u00b5\u00b5\n\u00b5\n");
}

TEST(WrappedText, PutsTheMeaningBehindItsTermOrBelowIt) {
  EXPECT_EQ(defined("-o", "to a file", 40, 8), "  -o    to a file\n");
  EXPECT_EQ(defined("--output", "to a file", 40, 8), "  --output\n        to a file\n");
}

TEST(WrappedTable, FitsTheWidthByTheCellsThatAreWidest) {
  const std::string table = wrapped_table({{"key", "a meaning of many words"}, {"bits", "few"}}, 25);
  EXPECT_EQ(table, "  key   a meaning of many\n        words\n  bits  few\n");
  EXPECT_LE(widest_line(wrapped_table({{"key", "a meaning of many words"}, {"bits", "few"}}, 20)), 20u);
}

TEST(FittedTable, StacksTheWordsOfItsHeaderWhereItIsTooWide) {
  EXPECT_EQ(fitted_table(figures, 80),
            "  filter        equivalent noise bandwidth  settling to 2 %  tracking error\n"
            "  velocity                         66.0 Hz          19.0 ms          18.4 %\n"
            "  acceleration                     61.6 Hz          24.0 ms          9.29 %\n");
  EXPECT_EQ(fitted_table(figures, 58),
            "                equivalent\n"
            "                     noise  settling to  tracking\n"
            "  filter         bandwidth          2 %     error\n"
            "  velocity         66.0 Hz      19.0 ms    18.4 %\n"
            "  acceleration     61.6 Hz      24.0 ms    9.29 %\n");
}

TEST(FittedTable, ContinuesBelowBehindTheSameFirstColumn) {
  const std::string table = fitted_table(figures, 36);
  EXPECT_LE(widest_line(table), 36u);
  for (const auto& row : figures)
    for (const std::string& cell : std::vector(row.begin() + 1, row.end()))
      EXPECT_NE(table.find(cell.substr(0, cell.find(' '))), std::string::npos) << cell;
  EXPECT_NE(table.find("velocity"), table.rfind("velocity"));
}

TEST(FittedTable, OfAnyWidthIsAsNarrowAsItsCellsPermit) {
  for (std::size_t width = 27; width < 90; ++width)
    EXPECT_LE(widest_line(fitted_table(figures, width)), width);
}

}  // namespace
}  // namespace qerr
