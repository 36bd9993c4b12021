
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "report/rows.hpp"

namespace qerr {
namespace {

TEST(JsonValue, WritesWhatAParserReadsBack) {
  Json j = {{"name", "elbow"}, {"range", {{"lower", -1.5}, {"upper", 1e-5}}}, {"used", true}};
  j["counts"] = Json::array({4096, {{"bits", std::size_t{14}}}});
  j["words"] = std::vector<std::string>{"a", "b\n\"c\""};
  EXPECT_EQ(parse_json(document(j), "report.json"), j);
  EXPECT_EQ(document(j), j.dump(2) + "\n");
  EXPECT_EQ(line(j), j.dump());
}

TEST(JsonValue, EscapesWhatATerminalObeys) {
  const std::string name = "a\x1b[31m\x7f\u009b31m\u00e9";
  const std::string text = line(name);
  EXPECT_EQ(text, "\"a\\u001b[31m\\u007F\\u009B31m\u00e9\"");
  EXPECT_EQ(line("\u202e\u200b\U000e0041\u20ac"), "\"\\u202E\\u200B\\uDB40\\uDC41\u20ac\"");
  EXPECT_EQ(parse_json(text, "report.json"), name);
}

TEST(JsonValue, IsNullWhereANumberIsNotFiniteOrNotKnown) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(line(infinity), "null");
  EXPECT_TRUE(json_of(infinity).is_null()) << "compare reads values that were never text";
  EXPECT_EQ(line(std::numeric_limits<double>::quiet_NaN()), "null");
  EXPECT_EQ(line({}), "null");
}

TEST(JsonValue, DistinguishesEmptyArraysFromEmptyObjects) {
  EXPECT_EQ(line(Json::array()), "[]");
  EXPECT_EQ(line(Json::object()), "{}");
  EXPECT_EQ(line(std::vector<std::string>()), "[]");
}

TEST(JsonValue, KeepsTheOrderOfItsMembersAndChangesThemInPlace) {
  Json j = {{"z", 1}, {"a", 2}};
  j["z"] = 3;
  j.update({{"m", 4}});
  EXPECT_EQ(line(j), R"({"z":3,"a":2,"m":4})");
}

TEST(JsonValue, ReplacesBytesThatAreNotUtf8) { EXPECT_EQ(line("a\xff"), "\"a\xEF\xBF\xBD\""); }

}  // namespace
}  // namespace qerr
