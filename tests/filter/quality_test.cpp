#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

TEST(Bandwidth, OfButterworthIsItsCutOffAtEveryOrder) {
  for (const double order : {1., 2., 5., 8.})
    for (const double cutoff : {0.1, 50., 400.})
      EXPECT_NEAR(*bandwidth(design_filter("butterworth", 0, 1000, order, cutoff)), cutoff, 1e-9 * cutoff)
          << order;
}

/// sqrt(2^(1/n) - 1) f0 of n equal poles, and of the derivative, at any sample rate.
TEST(Bandwidth, KeepsItsDigitsAtAnySampleRate) {
  for (const double rate : {1e5, 1e8, 1e11, 1e15})
    for (const int order : {2, 3, 8}) {
      const double exact = std::sqrt(std::exp2(1.0 / order) - 1);
      for (const int derivative : {0, 1})
        EXPECT_NEAR(*bandwidth(design_filter("first_order", derivative, rate, order, 1)) / exact, 1,
                    1e-12 + 40 / rate)
            << rate << ' ' << order << ' ' << derivative;
    }
}

/// A notch of relative width 1e-6 within the pass band: (s^2 + g s/4 + 1)/(s^2 + g s + 1), g = 1e-6, is 1/4
/// at its center. |H|^2 = 1/2 at (1 - W^2)^2 = 7/8 g^2 W^2.
TEST(Bandwidth, EndsAtTheFirstNotchHoweverNarrow) {
  const double g = 1e-6, slope = 1 / std::tan(0.01);
  const Filter f{{{{1, 0.25 * g * slope, slope * slope}, {1, g * slope, slope * slope}}}, 1, 1000, 0};
  const double x = 0.5 * g * std::sqrt(7 / 8.0), edge = std::sqrt(1 + x * x) - x;
  EXPECT_NEAR(*bandwidth(f), 1000 / pi * std::atan(std::tan(0.01) * edge), 1e-12);
}

TEST(Bandwidth, OfASlowFirstOrderDerivativeIsThatOfItsPole) {
  // Far below the sample rate the section is 1/(1 + s/w0): -3 dB at the cut-off.
  EXPECT_NEAR(*bandwidth(design_filter("first_order", 1, 1e6, 1, 10)), 10, 1e-3);
}

TEST(NoiseBandwidth, OfASlowFirstOrderLowPassIsHalfPiTimesItsCutOff) {
  const Filter f = design_filter("first_order", 0, 1e6, 1, 10);
  EXPECT_NEAR(noise_bandwidth(f, h2_norm(f)), 0.5 * pi * 10, 1e-3);
}

TEST(NoiseBandwidth, OfAnIdealDifferentiatorIsItsBandwidth) {
  // A single difference passes white noise of power 2 f_s^2: (2/f_s)(2 pi)^2 B^3/3 = 2 f_s^2.
  const Filter f = difference_filter(1000, 1);
  const double b = noise_bandwidth(f, h2_norm(f));
  EXPECT_NEAR(2 / 1000. * 4 * pi * pi * b * b * b / 3, 2e6, 1e-3);
}

TEST(Fidelity, FollowsTheFirstOrderLagAtLowFrequency) {
  const Filter f = design_filter("first_order", 1, 1e5, 1, 50);
  const Fidelity at = fidelity(f, 5);
  // 1/(1 + j f/f0): gain 1/sqrt(1.01), phase -atan(0.1); the difference adds half a sample of delay.
  EXPECT_NEAR(at.gain_error, 1 / std::sqrt(1.01) - 1, 1e-5);
  EXPECT_NEAR(at.phase_error, -std::atan(0.1) - 2 * pi * 5 * 0.5e-5, 2e-4);
  EXPECT_NEAR(at.tracking_error, std::abs(1.0 / std::complex<double>(1, 0.1) - 1.0), 2e-4);
}

TEST(Fidelity, OfADifferenceIsASincAndADelayOfHalfASample) {
  const Fidelity at = fidelity(difference_filter(1000, 1), 100);
  EXPECT_NEAR(at.gain_error, std::sin(0.1 * pi) / (0.1 * pi) - 1, 1e-14);
  EXPECT_NEAR(at.phase_error, -0.1 * pi, 1e-14);
}

/// |1/(1 + j x) - 1| = x/sqrt(1 + x^2), x = f/f0, far below the sample rate and far below the cut-off.
TEST(Fidelity, KeepsItsDigitsFarBelowTheCutOff) {
  const Filter f = design_filter("first_order", 0, 1e15, 1, 1);
  for (const double x : {1e-2, 1e-5, 1e-7}) {
    EXPECT_NEAR(fidelity(f, x).tracking_error / (x / std::sqrt(1 + x * x)), 1, 1e-12);
    EXPECT_NEAR(fidelity(f, x).gain_error / std::expm1(-0.5 * std::log1p(x * x)), 1, 1e-12);
  }
}

/// Resonances of Q = 1e4 and 1e8 within a band of a thousand times their width and more: the largest error is
/// the peak. Samples of the band alone would not meet the narrower one.
TEST(BandTracking, FindsANarrowPeak) {
  for (const double g : {1e-4, 1e-8})
    for (const double frequency : {10.0, 13.7, 41.0}) {
      const double slope = 1 / std::tan(pi * frequency / 1000);
      const Filter f{{{{1, 0, 0}, {1, g * slope, slope * slope}}}, 1, 1000, 0};
      // 1/(1 - W^2 + j g W) - 1 = (W^2 - j g W)/(1 - W^2 + j g W): its square is largest near W = 1.
      double largest = 0;
      for (int i = -10000; i <= 10000; ++i) {
        const double d = 1e-4 * g * i, w = 1 + d;  // 1 - w^2 = -d (2 + d)
        largest = std::max(largest, std::hypot(w * w, g * w) / std::hypot(d * (2 + d), g * w));
      }
      EXPECT_NEAR(band_tracking(f, 1, 50).largest / largest, 1, 1e-7) << g << ' ' << frequency;
    }
}

TEST(BandTracking, IsBetweenTheErrorsAtTheEndsOfTheBand) {
  const Filter f = design_filter("first_order", 1, 1000, 2, 50);
  const BandTracking t = band_tracking(f, 1, 10);
  EXPECT_DOUBLE_EQ(t.largest, fidelity(f, 10).tracking_error);
  EXPECT_GT(t.rms, fidelity(f, 1).tracking_error);
  EXPECT_LT(t.rms, t.largest);
}

TEST(SettlingTime, OfAFirstOrderLowPassIsFourTimeConstants) {
  // 1 - a^(k+1) >= 0.98 with a = exp(-2 pi f0 T).
  const double rate = 10000, cutoff = 5, x = 2 * pi * cutoff / rate;
  const double samples = std::ceil(std::log(0.02) / -x - 1);
  EXPECT_NEAR(*settling_time(design_filter("first_order", 0, rate, 1, cutoff)), samples / rate, 1.01 / rate);
  EXPECT_NEAR(*settling_time(design_filter("first_order", 2, rate, 1, cutoff)), samples / rate, 1.01 / rate);
}

/// The response to t^d/d!, by direct convolution.
TEST(SettlingTime, IsThatOfTheSampledRamp) {
  for (int d = 0; d <= 4; ++d)
    for (const int order : {d + 1, d + 2}) {
      const double rate = 200;
      const Filter f = design_filter("first_order", d, rate, order, 10);
      const std::vector<double> h = impulse_response(f, 400);
      int settled = 0;
      for (int k = 0; k < 400; ++k) {
        double y = 0;
        for (int i = 0; i <= k; ++i) {
          double ramp = 1;
          for (int j = 1; j <= d; ++j) ramp *= (k - i) / rate / j;
          y += h[static_cast<std::size_t>(i)] * ramp;
        }
        if (std::abs(y - 1) > 0.02) settled = k + 1;
      }
      EXPECT_NEAR(*settling_time(f) * rate, settled, 1e-9) << d << ' ' << order;
    }
}

/// a^(k+1) <= 0.02, a = exp(-x), for the first-order low-pass and, as the ramp lags by the same, its
/// derivative.
TEST(SettlingTime, OfASlowFilterIsComputedFromItsModes) {
  for (const double cutoff : {30.0, 1.0, 0.1}) {
    const double rate = 1e6, samples = std::log(50.0) / (2 * std::numbers::pi * cutoff / rate);
    for (const int derivative : {0, 1})
      EXPECT_NEAR(*settling_time(design_filter("first_order", derivative, rate, 1, cutoff)) * rate / samples,
                  1, 1e-4)
          << cutoff << ' ' << derivative;
  }
  // Ten times slower, ten times longer; also for oscillations.
  for (const char* family : {"butterworth", "first_order"})
    for (const int order : {2, 3, 5}) {
      const double fast = *settling_time(design_filter(family, 1, 1e5, order, 50));  // by terms
      const double slow = *settling_time(design_filter(family, 1, 1e5, order, 5));   // by modes
      EXPECT_NEAR(slow / fast, 10, 0.02) << family << order;
    }
}

/// 1 - (1 + k x) e^(-k x) >= 0.98 for two equal slow poles.
TEST(SettlingTime, IsExactToASampleForASlowFilter) {
  double kx = 5;
  for (int i = 0; i < 50; ++i) kx = std::log((1 + kx) / 0.02);
  for (const double rate : {1e7, 1e9, 1e12})
    EXPECT_NEAR(*settling_time(design_filter("first_order", 0, rate, 2, 1)) / (kx / (2 * pi)), 1,
                1e-12 + 5 / rate);
}

TEST(SettlingTime, IsEmptyForAFilterThatDoesNotEstimateItsDerivative) {
  EXPECT_FALSE(settling_time(filter_from_coefficients({3}, {1, -0.5}, 1000, 1)));
}

TEST(SecondOrderSections, HaveTheResponseOfTheFilter) {
  for (const char* name : {"first_order", "butterworth"}) {
    const Filter f = design_filter(name, 2, 1000, 5, 80);
    for (const double frequency : {1., 70., 300., 499.}) {
      const std::complex<double> q = std::polar(1.0, -2 * pi * frequency / 1000);
      std::complex<double> h = 1;
      for (const auto& s : second_order_sections(f))
        h *= (s[0] + q * (s[1] + q * s[2])) / (s[3] + q * (s[4] + q * s[5]));
      EXPECT_NEAR(std::abs(h / response(f, frequency) - 1.0), 0, 1e-9) << name << ' ' << frequency;
    }
  }
}

}  // namespace
}  // namespace qerr
