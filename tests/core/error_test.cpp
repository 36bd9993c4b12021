#include "qerr/core/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace qerr {
namespace {

TEST(Error, IsOneLineWithPlaceRuleFoundAndRemedyAndNoControlCharacters) {
  const std::string text =
      format({{{"a.yaml", 3, 7}, "encoders.x", "unknown key", "'b\x1b[2Jit\n'", "did you mean 'bits'?"}});
  EXPECT_EQ(text, "a.yaml:3:7: encoders.x: unknown key, found 'b\\x1B[2Jit\\x0A'; did you mean 'bits'?");
}

TEST(Error, HasAtMostTwentyLines) {
  const std::string text = format(std::vector<Fault>(100, {{"f", 1, 1}, "k", "r", "", ""}));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 19);
  EXPECT_NE(text.find("(81 more faults)"), std::string::npos);
}

}  // namespace
}  // namespace qerr
