#include "core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace qerr {
namespace {

TEST(Random, StreamsOfNeighbouringSeedsNamesAndIndicesShareNoSeed) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const char* name : {"", "tip", "bootstrap", "bootstraq"})
      for (std::uint64_t index = 0; index < 1000; ++index) seeds.insert(stream_seed(seed, name, index));
  EXPECT_EQ(seeds.size(), 20u * 4 * 1000);
}

TEST(Random, UnitIntervalHasTheMomentsOfAUniformDistribution) {
  constexpr int count = 100000;
  double sum = 0, squares = 0, products = 0, last = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double x = unit_interval(random_bits(stream_seed(1, "test"), i, 0)) - 0.5;
    sum += x;
    squares += x * x;
    products += x * last;
    last = x;
  }
  // Five standard deviations of mean, mean square and lag-1 product.
  EXPECT_NEAR(sum / count, 0, 5 * std::sqrt(1.0 / 12 / count));
  EXPECT_NEAR(squares / count, 1.0 / 12, 5 * std::sqrt(1.0 / 180 / count));
  EXPECT_NEAR(products / count, 0, 5 * std::sqrt(1.0 / 144 / count));
}

}  // namespace
}  // namespace qerr
