#include "core/search.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.hpp"
#include "core/statistics.hpp"

namespace qerr {
namespace {

double drawn(std::uint64_t index, std::uint64_t of) {
  return unit_interval(random_bits(stream_seed(1, "search"), index, of));
}

TEST(Search, BisectionEnclosesTheChangeWhicheverEndHolds) {
  for (std::uint64_t i = 0; i < 500; ++i) {
    const double low = -10 * drawn(i, 0), high = 10 * drawn(i, 1), at = low + (high - low) * drawn(i, 2);
    const Change rising = bisect({high, low}, 30, [&](double x) { return x >= at; });
    const Change falling = bisect({low, high}, 30, [&](double x) { return x < at; });
    EXPECT_EQ(rising.holds, falling.fails);
    EXPECT_EQ(rising.fails, falling.holds);
    EXPECT_LE(falling.holds, at);
    EXPECT_GE(falling.fails, at);
    EXPECT_NEAR(falling.middle(), at, std::ldexp(high - low, -30));
  }
}

TEST(Search, GoldenSectionsEncloseTheOnlyMaximum) {
  for (std::uint64_t i = 0; i < 500; ++i) {
    const double low = -10 * drawn(i, 3), high = 10 * drawn(i, 4), at = low + (high - low) * drawn(i, 5);
    int calls = 0;
    const Peak peak = golden_section(low, high, 30, [&](double x) { return ++calls, -std::abs(x - at); });
    const double width = (high - low) * std::pow(0.6180339887498949, 30);
    EXPECT_NEAR(peak.high - peak.low, width, 1e-6 * width);
    EXPECT_LE(peak.low, at + 1e-12);
    EXPECT_GE(peak.high, at - 1e-12);
    EXPECT_GE(peak.value, -width);
    EXPECT_EQ(calls, 32);
  }
}

TEST(Search, PercentilesLieBetweenTheirOrderStatistics) {
  for (std::uint64_t i = 0; i < 500; ++i) {
    const auto count = static_cast<std::uint64_t>(1 + 1000 * drawn(i, 6));
    const double fraction = drawn(i, 7);
    const PercentileRank rank(fraction, count);
    EXPECT_NEAR(static_cast<double>(rank.below) + rank.part, fraction * static_cast<double>(count - 1), 1e-9);
    EXPECT_TRUE(rank.part >= 0 && rank.part < 1);
    EXPECT_EQ(rank.permitted(count) + rank.below + 1, count);
  }
}

}  // namespace
}  // namespace qerr
