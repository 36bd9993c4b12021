#include "core/suggest.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace qerr {
namespace {

TEST(Suggest, FindsTheNearestNameAndNoDistantOne) {
  const std::vector<std::string> known{"counts_per_rev", "lines_per_rev", "bits", "resolution"};
  EXPECT_EQ(nearest("count_per_rev", known), "counts_per_rev");
  EXPECT_EQ(nearest("Bits", known), "bits");
  EXPECT_EQ(nearest("resoltuion", known), "resolution");
  EXPECT_EQ(nearest("colour", known), "");
}

}  // namespace
}  // namespace qerr
