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

}  // namespace
}  // namespace qerr
