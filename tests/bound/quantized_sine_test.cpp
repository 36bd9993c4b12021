#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "qerr/bound/velocity_estimators.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

struct Moments {
  double mean = 0, mean_square = 0, correlation = 0;
};

/// Quantizes `count` samples of the sine at evenly spread phases.
Moments simulated(double offset, double amplitude, int count) {
  Moments m;
  for (int i = 0; i < count; ++i) {
    const double s = amplitude * std::sin(2 * pi * (i + 0.37) / count);
    const double e = std::floor(offset + s + 0.5) - (offset + s);
    m.mean += e / count;
    m.mean_square += e * e / count;
    m.correlation += e * s / count;
  }
  return m;
}

TEST(QuantizedSine, HasTheMomentsOfASimulation) {
  for (const double offset : {0.0, 0.2, 0.5, -0.35, 7.9})
    for (const double amplitude : {0.0, 0.3, 1.0, 4.7, 9.99, 10.01, 31.4}) {
      const Moments m = simulated(offset, amplitude, 400000);
      EXPECT_NEAR(quantized_sine_mean(offset, amplitude), m.mean, 2e-5) << offset << ' ' << amplitude;
      EXPECT_NEAR(quantized_sine_mean_square(offset, amplitude), m.mean_square, 1e-5)
          << offset << ' ' << amplitude;
    }
}

TEST(QuantizedSine, AgreesWithExactIntegralsIn40Digits) {
  // mpmath: the error's exact integrals between the threshold crossings, 40 digits.
  const double golden[][4] = {
      {0.3, 0.1, -0.3, 0.095},
      {0.3, 0.7, 0.10776916889433203, 0.071050141507426578},
      {0.25, 2, -0.043298082054252258, 0.080874683798523394},
      {0.1, 9.96, -0.007045352824500208, 0.079314763968576461},
      {0.1, 10.04, -0.0097901086397883284, 0.076846047627913247},
      {0.37, 31.7, 0.010440740067907291, 0.079687731249638477},
      {-4.8, 261.8, 0.00080029660863681323, 0.083860393901734463},
      {0.125, 1000.625, 0.0042437589061136177, 0.084103589351944524},
      {0.5, 123456.7, 0.0, 0.083253120708496659},
  };
  for (const auto& g : golden) {
    EXPECT_NEAR(quantized_sine_mean(g[0], g[1]), g[2], 1e-12) << g[1];
    EXPECT_NEAR(quantized_sine_mean_square(g[0], g[1]), g[3], 1e-12) << g[1];
  }
}

TEST(QuantizedSine, IsContinuousWhereTheMethodChanges) {
  for (double offset = -0.5; offset <= 0.5; offset += 0.013) {
    const double below = std::nextafter(10.0, 0.0);
    EXPECT_NEAR(quantized_sine_mean(offset, below), quantized_sine_mean(offset, 10.0), 1e-7);
    EXPECT_NEAR(quantized_sine_mean_square(offset, below), quantized_sine_mean_square(offset, 10.0), 2e-13);
  }
}

TEST(QuantizedSine, SumsTheBesselSeries) {
  // Partial sums to K with averaged terms of the tail, which is below K^-3/2.
  for (const double amplitude : {0.4, 3.3, 12.25, 40.1}) {
    const double offset = 0.17;
    double square = 1.0 / 12;
    for (int k = 1; k <= 20000; ++k)
      square += (k % 2 ? -1 : 1) / (pi * pi * k * k) * std::cos(2 * pi * k * offset) *
                std::cyl_bessel_j(0, 2 * pi * k * amplitude);
    EXPECT_NEAR(quantized_sine_mean_square(offset, amplitude), square, 1e-8) << amplitude;
  }
}

TEST(QuantizedSine, IsWithinThePapersEnvelopeAndAttainsIt) {
  double mean = 0, below = 0, above = 0;
  for (double amplitude = 2; amplitude < 400; amplitude *= 1.003)
    for (double offset = 0; offset <= 0.5; offset += 0.01) {
      const SineEnvelope e = quantized_sine_envelope(amplitude);
      mean = std::max(mean, std::abs(quantized_sine_mean(offset, amplitude)) / e.mean);
      const double square = quantized_sine_mean_square(offset, amplitude) - 1.0 / 12;
      above = std::max(above, square / e.mean_square_above);
      below = std::max(below, square / e.mean_square_below);
    }
  // The printed figures are rounded: 0.1351, -0.0290, 0.0379.
  EXPECT_GT(mean, 0.97);
  EXPECT_LT(mean, 1.005);  // 0.1358 at amplitude 2.16: the printed one is rounded
  EXPECT_GT(above, 0.97);
  EXPECT_LT(above, 1.002);
  EXPECT_GT(below, 0.97);
  EXPECT_LT(below, 1.01);
}

TEST(QuantizedSine, ApproachesTheUniformErrorFromTheSmallestAmplitudes) {
  // The assumption of `ipqn_threshold`, at the offset that it uses.
  for (double amplitude = 1e-4; amplitude < 1000; amplitude *= 1.002)
    EXPECT_LE(std::abs(quantized_sine_mean_square(0.5, amplitude) - 1.0 / 12),
              std::min(1.0 / 6, 0.0381 / std::sqrt(amplitude)))
        << amplitude;
}

TEST(QuantizedSine, OutputVarianceIsFarOutsideThePapersEnvelope) {
  // Var x_hat - Var x = Var e + 2 E e(x - mean): Eq. 56 is about the error, not about the signal.
  double lowest = 0, highest = 0;
  for (const double amplitude : {261.0, 261.3})
    for (int k = 0; k <= 25; ++k) {
      const Moments m = simulated(0.02 * k, amplitude, 200000);
      const double change = m.mean_square - m.mean * m.mean + 2 * m.correlation;
      lowest = std::min(lowest, change);
      highest = std::max(highest, change);
    }
  // Of 2e6 samples: -5.97 at amplitude 261.0 and 2.80 at 261.3.
  EXPECT_NEAR(lowest, -5.97, 0.05);
  EXPECT_NEAR(highest, 2.80, 0.05);
}

}  // namespace
}  // namespace qerr
