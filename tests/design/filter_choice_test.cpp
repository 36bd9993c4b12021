#include "design/filter_choice.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

FilterRange range_of_first_order() {
  FilterRange range;
  range.families = {"first_order"};
  range.orders = {1, 2};
  range.least_cutoff = 1;
  range.most_cutoff = 400;
  return range;
}

bool anything(const Filter&) { return true; }

TEST(FilterChoice, TheQuietestStandsWhereTheDelayEnds) {
  FilterRange range = range_of_first_order();
  range.delay = 5e-3;
  const FilterScan scan = filter_candidates(range, 1, 1000, anything);
  for (const int order : {1, 2}) {
    double least = INFINITY, cutoff = 0;
    for (const FilterCandidate& c : scan.candidates) {
      EXPECT_LE(c.delay, 5e-3);
      if (c.order == order && c.h2 < least) {
        least = c.h2;
        cutoff = c.cutoff;
      }
    }
    // Delay of the cascade: half a sample of the difference, and a/(1 - a) samples of each pole a.
    const double a = std::exp(-2 * M_PI * cutoff / 1000);
    EXPECT_NEAR(0.5e-3 + order * a / (1 - a) * 1e-3, 5e-3, 1e-7) << "order " << order;
  }
}

TEST(FilterChoice, CandidatesKeepTheTrackingErrorBetweenSamplesToo) {
  FilterRange range;
  range.families = {"first_order", "butterworth", "chebyshev1", "elliptic", "bessel"};
  range.orders = {1, 2, 3};
  range.least_cutoff = 2;
  range.most_cutoff = 300;
  range.tracking = {{8, 0.3}};
  const FilterScan scan = filter_candidates(range, 1, 1000, anything);
  ASSERT_GT(scan.candidates.size(), 50u);
  for (const FilterCandidate& c : scan.candidates)
    for (int i = 1; i <= 100; ++i)
      ASSERT_LE(fidelity(c.filter, 8 * i / 100.0).tracking_error, 0.3 * (1 + 1e-9))
          << c.family << ' ' << c.cutoff;
}

TEST(FilterChoice, NoneWithinTheLimitsLeavesTheLeastThatIsReached) {
  FilterRange range = range_of_first_order();
  range.delay = 1e-6;
  const FilterScan scan = filter_candidates(range, 1, 1000, anything);
  EXPECT_TRUE(scan.candidates.empty());
  const auto fastest = low_pass("first_order", 1, 400, 1, 1000);
  ASSERT_TRUE(fastest);
  EXPECT_DOUBLE_EQ(scan.least_delay, group_delay(*fastest));
}

TEST(FilterChoice, AnUnknownOrderOfAFamilyIsNone) {
  EXPECT_FALSE(low_pass("butterworth", 5000, 30, 1, 1000));
  EXPECT_FALSE(low_pass("butterworth", 2, 600, 1, 1000));
  EXPECT_FALSE(low_pass("no_such_family", 2, 30, 1, 1000));
}

TEST(FilterChoice, NoFilterWinsByShrinkingSlowMotion) {
  FilterRange range;
  range.families = {"elliptic", "chebyshev1", "butterworth"};
  range.orders = {2, 3, 4};
  range.least_cutoff = range.most_cutoff = 40;
  const FilterScan scan = filter_candidates(range, 1, 1000, anything);
  std::size_t shrinking = 0;
  for (const std::string& family : range.families)
    for (const int order : range.orders) {
      const auto filter = low_pass(family, order, 40, 1, 1000);
      shrinking += filter && std::abs(low_frequency_gain(*filter) - 1) > 0.01;
    }
  EXPECT_GE(shrinking, 4u) << "even orders with ripple";
  EXPECT_EQ(scan.candidates.size() + shrinking, scan.filters);
  for (const FilterCandidate& c : scan.candidates)
    EXPECT_NEAR(low_frequency_gain(c.filter), 1, 0.01) << c.family << c.order;
}

}  // namespace
}  // namespace qerr
