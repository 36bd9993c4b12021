#include "qerr/encoder/encoder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace qerr {
namespace {

TEST(Encoder, ErrorOfQuantizingStaysInItsRangeAndHasItsMeanAndSigma) {
  for (const Rounding rounding : {Rounding::nearest, Rounding::down}) {
    const Encoder encoder{0.01, rounding, true};
    double sum = 0, squares = 0;
    constexpr int count = 100000;
    for (int i = 0; i < count; ++i) {
      const double position = -1 + 2.0 * (i + 0.5) / count;
      const double error = quantize(encoder, position) - position;
      ASSERT_LE(std::abs(error - mean_error(encoder)), 0.005 + 1e-15) << position;
      sum += error;
      squares += error * error;
    }
    const double mean = sum / count;
    EXPECT_NEAR(mean, mean_error(encoder), 1e-5 * encoder.resolution);
    EXPECT_NEAR(std::sqrt(squares / count - mean * mean), sigma(encoder), 1e-5 * encoder.resolution);
  }
}

TEST(Encoder, ACounterThatRoundsDownShowsNoMoreThanThePositionInItsOwnDirection) {
  for (const double ratio : {10.0, -10.0}) {
    const Encoder encoder{.resolution = 0.01, .rounding = Rounding::down, .shaft_ratio = ratio};
    EXPECT_DOUBLE_EQ(mean_error(encoder), ratio > 0 ? -0.005 : 0.005);
    for (double position = -1.0003; position < 1; position += 0.00713) {
      const double counter = std::floor(position * (ratio > 0 ? 1 : -1) / 0.01);  // what it shows
      EXPECT_NEAR(quantize(encoder, position), (ratio > 0 ? 1 : -1) * counter * 0.01, 1e-15) << position;
    }
  }
}

}  // namespace
}  // namespace qerr
