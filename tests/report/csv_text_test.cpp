#include <gtest/gtest.h>

#include "input/csv.hpp"
#include "report/rows.hpp"

namespace qerr {
namespace {

TEST(CsvCell, IsQuotedWhereItWouldBeReadOtherwise) {
  EXPECT_EQ(csv_cell("a b"), "a b");
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_cell("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(csv_cell(" a"), "\" a\"");
  EXPECT_EQ(csv_cell("a "), "\"a \"");
  EXPECT_EQ(csv_cell("#a"), "\"#a\"");
}

TEST(CsvCell, IsNoFormulaAndNoEscapeSequence) {
  EXPECT_EQ(csv_cell("=cmd|x"), "'=cmd|x");
  EXPECT_EQ(csv_cell("@sum"), "'@sum");
  EXPECT_EQ(csv_cell("+joint"), "'+joint");
  EXPECT_EQ(csv_cell("-5 deg"), "-5 deg");
  EXPECT_EQ(csv_cell("-1.5"), "-1.5");
  EXPECT_EQ(csv_cell("-"), "-");
  EXPECT_EQ(csv_cell("\x1b[31m"), "\\x1B[31m");
  EXPECT_EQ(csv_cell("a\u009bb"), "a\\xC2\\x9Bb");
  EXPECT_EQ(csv_cell("a\u202eb"), "a\\xE2\\x80\\xAEb");
}

TEST(CsvCell, OfAnyNameIsReadAsThatName) {
  for (const std::string name : {"a", "=a", "'=a", "''a", "'a", "-a", "+a", "@a", "#a", " a", "a[b]"}) {
    std::string cell = csv_cell(name + ".reference [rad]");
    if (cell.starts_with('"')) cell = cell.substr(1, cell.size() - 2);
    EXPECT_EQ(column_name(cell).name, name + ".reference");
    EXPECT_EQ(column_name(cell).unit, "rad");
  }
}

}  // namespace
}  // namespace qerr
