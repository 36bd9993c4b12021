#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/text.hpp"

namespace qerr {
namespace {

TEST(Suggest, FindsTheNearestNameAndNoDistantOne) {
  const std::vector<std::string> known{"counts_per_rev", "lines_per_rev", "bits", "resolution"};
  EXPECT_EQ(nearest("count_per_rev", known), "counts_per_rev");
  EXPECT_EQ(nearest("Bits", known), "bits");
  EXPECT_EQ(nearest("resoltuion", known), "resolution");
  EXPECT_EQ(nearest("colour", known), "");
}

TEST(Suggest, DoesNotGuessAmongManyNamesOrFromAFewLetters) {
  EXPECT_EQ(nearest("median", {"min", "mean", "max"}), "");
  EXPECT_EQ(did_you_mean("a9", {"a1", "a2", "a3"}), "known: a1, a2, a3");
  EXPECT_EQ(did_you_mean("w", {"x"}), "known: x");
  EXPECT_EQ(did_you_mean("X", {"x", "y"}), "did you mean 'x'?");
  EXPECT_EQ(did_you_mean("p98", {"mean", "p50", "p95", "p99"}), "did you mean 'p95' or 'p99'?");
  EXPECT_EQ(did_you_mean("joint_9", {"joint_1", "joint_2", "joint_3"}), "known: joint_1, joint_2, joint_3");
}

}  // namespace
}  // namespace qerr
