#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "bound/histogram.hpp"
#include "qerr/bound/figure.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

JoinedTally tally_of(const std::vector<double>& values, std::size_t block = 1000) {
  JoinedTally joined;
  for (std::size_t first = 0; first < values.size(); first += block) {
    Tally tally;
    const std::size_t count = std::min(block, values.size() - first);
    tally_some(values.data() + first, count, first, tally);
    joined.append(tally, count);
  }
  return joined;
}

Statistic statistic_of(const std::vector<double>& values) {
  const JoinedTally tally = tally_of(values);
  return statistic(tally, order_statistics(values, tally));
}

Statistic binned_statistic_of(const std::vector<double>& values, double typical, int parts = 1) {
  const std::int32_t lowest = Histogram::lowest_bin(leading_bits(typical));
  std::vector<Histogram> histograms;
  for (int i = 0; i < parts; ++i) histograms.emplace_back(lowest);
  for (std::size_t i = 0; i < values.size(); ++i) histograms[i % histograms.size()].add(values[i]);
  for (std::size_t i = 1; i < histograms.size(); ++i) histograms[0].append(histograms[i]);
  const JoinedTally tally = tally_of(values);
  return statistic(tally, [&](std::uint64_t rank) {
    return histograms[0].order_statistic(rank, tally.min(), tally.max());
  });
}

// A member without a row would be missing in specs and reports.
TEST(Statistic, EveryMemberHasARow) {
  Statistic s;
  double value = 1;
  for (const StatisticKind& kind : statistic_kinds()) {
    EXPECT_EQ(s.*kind.value, 0) << kind.name << " has the member of another row";
    EXPECT_EQ(find_statistic(kind.name), &kind);
    s.*kind.value = value++;
  }
  EXPECT_EQ(statistic_kinds().size(), offsetof(Statistic, at_max) / sizeof(double));
  EXPECT_EQ(find_statistic("p98"), nullptr);
  for (const StatisticKind& kind : statistic_kinds())
    EXPECT_EQ(scaled(s, 2).*kind.value, 2 * (s.*kind.value));
}

// Golden: numpy's definition in exact fractions; 1e-15 relative.
TEST(Statistic, PercentilesAreNumpysLinearOnes) {
  struct Case {
    std::vector<double> values;
    double p50, p95, p99, mean;
  };
  for (const Case& c :
       {Case{{3, 1, 2}, 2, 2.9, 2.98, 2}, Case{{4, 1, 3, 2}, 2.5, 3.85, 3.97, 2.5}, Case{{7}, 7, 7, 7, 7},
        Case{{0.5, 10, 2, 8, 2.5, 0, 1, 9, 100, 3, 4}, 3, 55, 91, 140.0 / 11}}) {
    const Statistic s = statistic_of(c.values);
    EXPECT_DOUBLE_EQ(s.p50, c.p50);
    EXPECT_DOUBLE_EQ(s.p95, c.p95);
    EXPECT_DOUBLE_EQ(s.p99, c.p99);
    EXPECT_DOUBLE_EQ(s.mean, c.mean);
    EXPECT_EQ(s.min, *std::min_element(c.values.begin(), c.values.end()));
    EXPECT_EQ(s.max, *std::max_element(c.values.begin(), c.values.end()));
  }
}

// What a job counts, so that it need not count again.
TEST(Statistic, TheRanksOfPercentilesAreThoseBetweenWhichTheyLie) {
  using Ranks = std::vector<std::uint64_t>;
  EXPECT_EQ(percentile_ranks(0.5, 4), (Ranks{1, 2}));
  EXPECT_EQ(percentile_ranks(0.5, 5), Ranks{2});
  EXPECT_EQ(percentile_ranks(0.95, 101), Ranks{95});
  EXPECT_EQ(percentile_ranks(0.99, 102), (Ranks{99, 100}));
  EXPECT_EQ(percentile_ranks(102), (Ranks{50, 51, 95, 96, 99, 100}));
}

// Tolerance 1e-3 for any values; 5e-5 for 200000 uniform values.
TEST(Histogram, PercentilesAreWithinTheirStatedError) {
  Dice dice(1);
  for (const bool evenly : {false, true}) {
    std::vector<double> values(200000);
    for (double& v : values)
      v = evenly ? dice.between(10, 1000) : std::pow(10.0, 3 - 30 * std::pow(dice.between(0, 1), 4));
    values.resize(values.size() + 1000, 0.0);
    const Statistic binned = binned_statistic_of(values, 1.0), exact = statistic_of(values);
    EXPECT_NE(binned.p50, exact.p50) << "bins were not in use";
    for (const auto p : {&Statistic::p50, &Statistic::p95, &Statistic::p99})
      EXPECT_NEAR(binned.*p, exact.*p, (evenly ? 5e-5 : 1e-3) * exact.*p);
    EXPECT_EQ(binned.min, 0);
    EXPECT_EQ(binned.max, exact.max);
  }
}

TEST(Histogram, IsIndependentOfItsPartsAndValidBeyondItsSpan) {
  Dice dice(9);
  std::vector<double> values{0, 1e-300, 1e300, INFINITY};
  for (int i = 0; i < 9999; ++i) values.push_back(dice.between(0, 7));
  const Statistic whole = binned_statistic_of(values, 3), parts = binned_statistic_of(values, 3, 5);
  EXPECT_EQ(whole.p50, parts.p50);
  EXPECT_EQ(whole.p95, parts.p95);
  EXPECT_EQ(whole.p99, parts.p99);
  EXPECT_NEAR(whole.p50, 3.5, 0.1);
}

// Ranks in counted bins are exact; other ranks are reported as not counted.
TEST(Histogram, HasTheOrderStatisticsOfItsCountedBinsOnly) {
  Dice dice(5);
  for (int round = 0; round < 6; ++round) {
    std::vector<double> values(5000);
    for (double& v : values) {
      const double kind = dice.between(0, 1);
      v = kind < 0.05 ? 0 : kind < 0.1 ? 0x1p-50 * dice.between(0, 1) : std::pow(dice.between(0, 1), 3);
      if (kind > 0.99) v *= 0x1p30;
    }
    std::sort(values.begin(), values.end());
    const auto bin = [&](double p) { return leading_bits(values[static_cast<std::size_t>(p * 4999)]); };
    const double low = dice.between(0.15, 0.6), high = dice.between(low, 0.7);
    const CountedBins near{bin(low), bin(high) + 1, bin(dice.between(high, 1))},
        counted = round % 3 == 0 ? CountedBins{} : near;
    const std::int32_t lowest = Histogram::lowest_bin(leading_bits(1));
    const auto a = static_cast<std::int32_t>(dice.between(-70000, 70000)),
               b = static_cast<std::int32_t>(dice.between(0, 70000));
    Histogram all(lowest), some(lowest, counted, {lowest + a, b}), other(lowest, counted);
    for (std::size_t i = 0; i < values.size(); ++i) {
      all.add(values[i]);
      (i % 3 == 0 ? some : other).add(values[i]);
    }
    some.append(other);
    for (std::size_t rank = 0; rank < values.size(); rank += 7) {
      EXPECT_TRUE(all.counts(rank));
      ASSERT_EQ(some.counts(rank), counted(leading_bits(values[rank])));
      if (!some.counts(rank)) continue;
      ASSERT_EQ(some.order_statistic(rank, values.front(), values.back()),
                all.order_statistic(rank, values.front(), values.back()));
    }
  }
}

// Extremes and percentiles are independent of the blocks; the mean up to rounding (1e-14).
TEST(Statistic, IsTheSameForAnyBlocks) {
  Dice dice(2);
  std::vector<double> values(999);
  for (double& v : values) v = dice.between(0, 1);
  const JoinedTally whole = tally_of(values, 999);
  for (const std::size_t size : {1u, 10u, 998u}) {
    const JoinedTally joined = tally_of(values, size);
    EXPECT_EQ(joined.min(), whole.min());
    EXPECT_EQ(joined.max(), whole.max());
    EXPECT_EQ(joined.at_max(), whole.at_max());
    EXPECT_NEAR(joined.mean(), whole.mean(), 1e-14);
  }
}

TEST(Statistic, NamesTheFirstConfigurationWithTheMaximumButForRounding) {
  EXPECT_EQ(tally_of({1, 5, 2, 5}).at_max(), 1u);
  EXPECT_EQ(tally_of({0, 0}).at_max(), 0u);
  EXPECT_EQ(tally_of({1, 5, std::nextafter(5, 6)}).at_max(), 1u);
  EXPECT_EQ(tally_of({1, 5, std::nextafter(5, 6)}).max(), std::nextafter(5, 6));
  EXPECT_EQ(tally_of({1, 5, 2, 5 * (1 + 1e-14)}, 2).at_max(), 1u);
  EXPECT_EQ(tally_of({1, 5, 2, 5 * (1 + 1e-12)}, 2).at_max(), 3u);
}

TEST(Statistic, InfiniteValuesGiveInfinitiesAndNoNaN) {
  const auto both = [](const std::vector<double>& values) {
    return std::vector{statistic_of(values), binned_statistic_of(values, 2)};
  };
  for (const Statistic& some : both({1, 2, INFINITY, 3, 4})) {
    EXPECT_EQ(some.max, INFINITY);
    EXPECT_EQ(some.mean, INFINITY);
    EXPECT_NEAR(some.p50, 3, 3e-3);
    EXPECT_EQ(some.p95, INFINITY);
  }
  for (const Statistic& all : both({INFINITY, INFINITY, INFINITY}))
    for (const double value : {all.min, all.mean, all.max, all.p50, all.p95, all.p99})
      EXPECT_EQ(value, INFINITY);
  for (const Statistic& none : both({0, 0, 0}))
    for (const double value : {none.min, none.mean, none.max, none.p50, none.p99}) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace qerr
