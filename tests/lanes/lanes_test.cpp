#include "lanes/lanes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// Largest error of sine and cosine over random arguments within +-span, relative to long double.
template <class SineCosine, class Angle>
long double worst_error(SineCosine sincos, Angle angle, double span, std::uint64_t seed) {
  Dice dice(seed);
  long double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const lanes::Lanes<2> x{dice.between(-span, span), dice.between(-span, span)};
    const auto s = sincos(x);
    for (std::size_t k = 0; k < 2; ++k)
      worst = std::max({worst, std::abs(std::sin(angle(x[k])) - s.sine[k]),
                        std::abs(std::cos(angle(x[k])) - s.cosine[k])});
  }
  return worst;
}

// For angles of usual joints and for the largest allowed ones.
TEST(Lanes, SineAndCosineAreAccurateToTwoUnitsInTheLastPlace) {
  const auto sincos = [](const lanes::Lanes<2>& x) { return lanes::sincos(x); };
  const auto angle = [](double x) { return static_cast<long double>(x); };
  for (const double span : {1e-300, 1e-8, 0.7, 0.8, 3.2, 100.0, lanes::largest_angle})
    EXPECT_LT(worst_error(sincos, angle, span, 3), 2.7e-16L) << "angles up to " << span;
}

TEST(Lanes, SineAndCosineOfQuarterTurnsAreAccurateToTwoUnitsInTheLastPlace) {
  const auto sincos = [](const lanes::Lanes<2>& x) { return lanes::sincos_of_quarters(x); };
  const auto angle = [](double x) { return std::remainder(x, 4.0) * (std::numbers::pi_v<long double> / 2); };
  for (const double span : {1e-300, 1e-8, 0.45, 0.55, 2.0, 64.0, lanes::largest_angle})
    EXPECT_LT(worst_error(sincos, angle, span, 4), 2.7e-16L) << "quarter turns up to " << span;
}

}  // namespace
}  // namespace qerr
