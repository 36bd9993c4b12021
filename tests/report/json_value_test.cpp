#include "report/json_value.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace qerr {
namespace {

using Parsed = nlohmann::ordered_json;

TEST(JsonValue, WritesWhatAParserReadsBack) {
  Json j = {{"name", "elbow"}, {"range", {{"lower", -1.5}, {"upper", 1e-5}}}, {"used", true}};
  j["counts"].push_back(4096);
  j["counts"].push_back({{"bits", std::size_t{14}}});
  j["words"] = std::vector<std::string>{"a", "b\n\"c\""};
  const Parsed expected = {{"name", "elbow"},
                           {"range", {{"lower", -1.5}, {"upper", 1e-5}}},
                           {"used", true},
                           {"counts", {4096, {{"bits", 14}}}},
                           {"words", {"a", "b\n\"c\""}}};
  EXPECT_EQ(Parsed::parse(j.document()), expected);
  EXPECT_EQ(j.document(), expected.dump(2) + "\n");
  EXPECT_EQ(j.line(), expected.dump());
}

TEST(JsonValue, EscapesWhatATerminalObeys) {
  const std::string name = "a\x1b[31m\x7f\u009b31m\u00e9";
  const std::string line = Json(name).line();
  EXPECT_EQ(line, "\"a\\u001b[31m\\u007F\\u009B31m\u00e9\"");
  EXPECT_EQ(Json("\u202e\u200b\U000e0041\u20ac").line(), "\"\\u202E\\u200B\\uDB40\\uDC41\u20ac\"");
  EXPECT_EQ(Parsed::parse(line), name);
}

TEST(JsonValue, IsNullWhereANumberIsNotFiniteOrNotKnown) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Json(infinity).line(), "null");
  EXPECT_TRUE(Json(infinity).is_null()) << "compare reads values that were never text";
  EXPECT_EQ(Json(std::numeric_limits<double>::quiet_NaN()).line(), "null");
  EXPECT_EQ(Json().line(), "null");
}

TEST(JsonValue, DistinguishesEmptyArraysFromEmptyObjects) {
  EXPECT_EQ(Json::array().line(), "[]");
  EXPECT_EQ(Json::object().line(), "{}");
  EXPECT_EQ(Json(std::vector<std::string>()).line(), "[]");
}

TEST(JsonValue, KeepsTheOrderOfItsMembersAndChangesThemInPlace) {
  Json j = {{"z", 1}, {"a", 2}};
  j["z"] = 3;
  j.append({{"m", 4}});
  EXPECT_EQ(j.line(), R"({"z":3,"a":2,"m":4})");
}

TEST(JsonValue, ReplacesBytesThatAreNotUtf8) { EXPECT_EQ(Json("a\xff").line(), "\"a\xEF\xBF\xBD\""); }

}  // namespace
}  // namespace qerr
