#include <gtest/gtest.h>

#include <cmath>

#include "qerr/core/parameter.hpp"

namespace qerr {
namespace {

TEST(PhysicalRange, BoundsWhatARowLeavesOpen) {
  const Parameter open = with_physical_range(
      {.name = "a", .least = 0, .open_below = true, .coordinate = true}, dimension::length);
  EXPECT_EQ(open.least, physical_range(dimension::length).smallest);
  EXPECT_FALSE(open.open_below);
  EXPECT_EQ(open.most, physical_range(dimension::length).largest);
  const Parameter both = with_physical_range({.name = "b", .dimension = dimension::time}, {});
  EXPECT_EQ(both.least, -both.most);
}

TEST(PhysicalRange, KeepsTheBoundsOfTheRow) {
  const Parameter row{.name = "a", .dimension = dimension::time, .least = -3, .most = 7};
  const Parameter same = with_physical_range(row, {});
  EXPECT_EQ(same.least, -3);
  EXPECT_EQ(same.most, 7);
}

TEST(PhysicalRange, HasNormalSquaresAndTheConstantsOfNature) {
  for (const Dimension d : {dimension::none, dimension::length, dimension::angle, dimension::time,
                            dimension::speed, dimension::compliance}) {
    const PhysicalRange r = physical_range(d);
    EXPECT_TRUE(std::isnormal(r.smallest * r.smallest));
    EXPECT_TRUE(std::isnormal(r.largest * r.largest));
  }
  EXPECT_GT(physical_range(dimension::speed).largest, 299792458);
  EXPECT_GT(physical_range(dimension::length).largest, 1.3e7);
  EXPECT_LT(physical_range(dimension::length).smallest, 1e-12);  // of interferometers
}

}  // namespace
}  // namespace qerr
