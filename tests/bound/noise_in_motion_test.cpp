#include "bound/noise_in_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "core/random.hpp"
#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"

namespace qerr {
namespace {

using std::numbers::phi;
using std::numbers::pi;

/// Mean square of the filtered quantization error along the path x(k) from sample `settled` on, by the
/// paper's recursion.
template <class Path>
double simulated_mean_square(int derivative, int order, double cutoff, Path x, int settled, int samples) {
  const double f = 1000, a = std::exp(-2 * pi * cutoff / f);
  std::vector<double> before(static_cast<std::size_t>(derivative)), low(static_cast<std::size_t>(order));
  double sum = 0;
  for (int k = 0; k < settled + samples; ++k) {
    double y = std::floor(x(k) + 0.5) - x(k);
    for (double& b : before) {
      const double now = y;
      y = (y - b) * f;
      b = now;
    }
    for (double& l : low) y = l = (1 - a) * y + a * l;
    if (k >= settled) sum += y * y;
  }
  return sum / samples;
}

double ratio(const Filter& filter, double v) {
  const Autocorrelation a = autocorrelation(filter);
  return constant_speed_sigma(a, v) / ipqn_sigma(a);
}

TEST(Autocorrelation, ContainsTheNormAndTheDcGain) {
  for (int d = 0; d <= 2; ++d)
    for (int n = 1; n <= 4; ++n)
      for (const double cutoff : {0.5, 50., 400.}) {
        const Filter filter = cascade(d, n, cutoff);
        const Autocorrelation a = autocorrelation(filter);
        EXPECT_NEAR(std::sqrt(a.r[0]) / h2_norm(filter), 1, 1e-13);
        double sum = 0;
        for (std::size_t k = a.r.size(); k-- > 1;) sum += 2 * a.r[k];
        EXPECT_NEAR((sum + a.r[0] - a.dc_gain * a.dc_gain) / a.r[0], 0, 1e-9) << d << n << cutoff;
        EXPECT_LT(a.tail, 1e-8 * a.r[0]) << d << n << cutoff;
      }
}

TEST(Autocorrelation, RejectsAFilterWithTooLongAMemory) {
  EXPECT_THROW(autocorrelation(filter_from_coefficients({1}, {1, -1 + 1e-9}, 1000, 0)), Error);
}

TEST(ConstantSpeed, AgreesWithASimulatedRamp) {
  for (const int d : {0, 1, 2})
    for (const int n : {1, 2, 3})
      for (const double v :
           {0.01 * std::numbers::sqrt2, 0.1 * std::numbers::e, std::numbers::phi, 7.7 + 1e-3 * pi}) {
        const double mean_square = simulated_mean_square(
            d, n, 50, [&](int k) { return 0.123 + k * v; }, 1000, 1000000);
        EXPECT_NEAR(constant_speed_sigma(cascade(d, n), v) / std::sqrt(mean_square), 1, 1e-3)
            << d << n << ' ' << v;
      }
}

TEST(ConstantSpeed, AgreesWithASimulatedRampAtRationalSpeedsForAnyZero) {
  for (const int d : {1, 2})
    for (const auto& [p, q] : {std::pair{1, 2}, {2, 3}, {5, 4}, {1, 10}, {77, 50}})
      for (const double zero : {0.01, 0.26, 0.777}) {
        // (p k mod q) is exact, so that the error repeats exactly.
        const auto x = [&, p = p, q = q](int k) { return zero + static_cast<double>(p * k % (50 * q)) / q; };
        const double mean_square = simulated_mean_square(d, 2, 50, x, 1000 * q, 200 * q);
        EXPECT_NEAR(constant_speed_sigma(cascade(d, 2), static_cast<double>(p) / q) / std::sqrt(mean_square),
                    1, 1e-9)
            << d << ' ' << p << '/' << q;
      }
}

TEST(ConstantSpeed, OfAFilterThatPassesConstantsIsTheRootMeanSquareOverTheZero) {
  double mean_square = 0;
  constexpr int zeros = 400;
  for (int i = 0; i < zeros; ++i) {
    const auto x = [&](int k) { return (i + 0.5) / zeros + 0.25 * (k % 4); };
    mean_square += simulated_mean_square(0, 1, 50, x, 2000, 400) / zeros;
  }
  EXPECT_NEAR(constant_speed_sigma(cascade(0, 1), 0.25) / std::sqrt(mean_square), 1, 1e-4);
}

TEST(ConstantSpeed, IsZeroAtWholeQuantaPerSample) {
  for (const int d : {1, 2, 3})
    for (const double v : {0., 1., 2., 10., -7., 1e6}) EXPECT_EQ(constant_speed_sigma(cascade(d, 2), v), 0);
  EXPECT_NEAR(constant_speed_sigma(cascade(0, 2), 3), 1 / std::sqrt(12.), 1e-15);
}

TEST(ConstantSpeed, IsTheSumOverTheHarmonicsAtRationalSpeeds) {
  for (const int d : {0, 1, 2})
    for (const int q : {2, 3, 7, 100})
      for (const int p : {1, q - 1, q + 1}) {
        const Filter filter = cascade(d, 2);
        double sum = std::norm(dc_gain(filter)) / (12. * q * q);
        for (int m = 1; m < q; ++m)
          sum += std::norm(response(filter, 1000. * (m * p % q) / q)) /
                 (4. * q * q * std::pow(std::sin(pi * m / q), 2));
        EXPECT_NEAR(constant_speed_sigma(filter, static_cast<double>(p) / q) / std::sqrt(sum), 1, 1e-11)
            << d << p << q;
      }
}

TEST(ConstantSpeed, IsTheSumOverTheHarmonicsAtIrrationalSpeeds) {
  for (const int d : {1, 2})
    for (const double v : {std::numbers::phi, 0.05 * std::numbers::sqrt3}) {
      const Filter filter = cascade(d, 2);
      constexpr int terms = 200000;
      double sum = std::norm(h2_norm(filter)) / (2 * pi * pi * (terms + 0.5));
      for (int k = 1; k <= terms; ++k)
        sum += std::norm(response(filter, 1000 * std::remainder(k * v, 1.0))) /
               (2 * pi * pi * k * static_cast<double>(k));
      EXPECT_NEAR(constant_speed_sigma(filter, v) / std::sqrt(sum), 1, 1e-8);
    }
}

TEST(ConstantSpeed, IsEvenAndPeriodicInTheSpeed) {
  const Autocorrelation a = autocorrelation(cascade(1, 2));
  for (const double v : {0.03125, 0.25, 0.40625}) {
    EXPECT_DOUBLE_EQ(constant_speed_sigma(a, v), constant_speed_sigma(a, -v));
    EXPECT_DOUBLE_EQ(constant_speed_sigma(a, v), constant_speed_sigma(a, v + 1024));
    EXPECT_DOUBLE_EQ(constant_speed_sigma(a, v), constant_speed_sigma(a, 1 - v));
  }
}

TEST(ConstantSpeed, AveragesToIpqnOverAllSpeeds) {
  for (const int d : {0, 1, 2})
    for (const int n : {1, 2, 3}) {
      const Autocorrelation a = autocorrelation(cascade(d, n));
      constexpr int speeds = 10007;
      double sum = 0;
      for (int i = 0; i < speeds; ++i)
        sum += std::pow(constant_speed_sigma(a, (i + 0.5) / speeds), 2) / speeds;
      EXPECT_NEAR(std::sqrt(sum) / ipqn_sigma(a), 1, 1e-6) << d << n;
    }
}

TEST(ConstantSpeed, ReproducesTheTableOfRatiosToIpqn) {
  // Independently computed, f = 1000 Hz, f0 = 50 Hz, three digits; at nearby irrational speeds.
  const double speeds[] = {.01, .02, .05, .1, .2, .25, 1. / 3, .5, .75, 1, 1.25, 2.3, 7.7, 10};
  const double one[] = {.458, .624,  .872, .999,  1.036, 1.031, 1.010,
                        .931, 1.031, .037, 1.031, 1.054, 1.054, .037};
  const double two[] = {1.055, 1.379, 1.591, 1.254, .816, .711, .605,
                        .488,  .711,  .088,  .711,  .784, .784, .088};
  for (std::size_t i = 0; i < std::size(speeds); ++i) {
    EXPECT_NEAR(ratio(cascade(1, 1), speeds[i] + 6.18e-5), one[i], 0.0007) << speeds[i];
    EXPECT_NEAR(ratio(cascade(1, 2), speeds[i] + 6.18e-5), two[i], 0.0007) << speeds[i];
  }
}

TEST(ConstantSpeed, IsWorstByTheKnownFactors) {
  const auto largest = [](const Filter& filter) {
    const Autocorrelation a = autocorrelation(filter);
    double most = 0;
    for (double v = 1e-3; v <= 0.5; v += 1e-4)
      most = std::max(most, constant_speed_sigma(a, v) / ipqn_sigma(a));
    return most;
  };
  EXPECT_NEAR(largest(cascade(1, 1)), 1.058, 0.001);
  EXPECT_NEAR(largest(cascade(1, 2)), 1.603, 0.001);
  EXPECT_NEAR(largest(cascade(1, 3)), 2.29, 0.01);
  EXPECT_NEAR(largest(cascade(2, 2)), 1.08, 0.01);
  EXPECT_NEAR(largest(cascade(2, 3)), 1.44, 0.01);
}

TEST(SineSigma, AgreesWithASimulatedSineOverTheZero) {
  for (const int n : {1, 2, 3})
    for (const auto& [amplitude, cycles] :
         {std::pair{261.8, 0.0015 * phi}, {3.3, 0.012 * phi}, {0.8, 0.011 * phi}, {12.0, 0.2 * phi}}) {
      double mean_square = 0;
      constexpr int zeros = 200;
      for (int i = 0; i < zeros; ++i)
        mean_square +=
            simulated_mean_square(
                1, n, 50,
                [&, amplitude = amplitude, cycles = cycles](int k) {
                  return (i + 0.5) / zeros + amplitude * std::sin(2 * pi * std::fmod(cycles * k, 1.0));
                },
                1000, 10000) /
            zeros;
      const Autocorrelation a = autocorrelation(cascade(1, n));
      EXPECT_NEAR(sine_sigma(a, amplitude, cycles) / std::sqrt(mean_square), 1, 3e-3)
          << n << ' ' << amplitude;
    }
}

TEST(SineSigma, TendsToTheMeanOfConstantSpeedsForSlowSines) {
  for (const int n : {1, 2}) {
    const Autocorrelation a = autocorrelation(cascade(1, n));
    for (const double peak : {0.07, 0.9, 4.11, 40.3}) {
      constexpr int speeds = 200000;
      double sum = 0;
      for (int i = 0; i < speeds; ++i)
        sum += std::pow(constant_speed_sigma(a, peak * std::sin(0.5 * pi * (i + 0.5) / speeds)), 2) / speeds;
      const double slow = slow_sine_sigma(a, peak);
      EXPECT_NEAR(slow / std::sqrt(sum), 1, 1e-6) << peak;
      EXPECT_NEAR(slow / sine_sigma(a, peak / (2 * pi * 1e-7), 1e-7), 1, 1e-6) << peak;
    }
  }
}

TEST(SineSigma, ReproducesTheSineAveragedTheoryOfThePapersExperiment) {
  // 4.1123 quanta per sample at the peak, f0 = 50 Hz: predicted ratios to IPQN.
  const double predicted[] = {0.984, 1.068, 1.109};
  for (int n = 1; n <= 3; ++n) {
    const Autocorrelation a = autocorrelation(cascade(1, n));
    EXPECT_NEAR(slow_sine_sigma(a, 4.1123) / ipqn_sigma(a), predicted[n - 1], 0.0011) << n;
  }
}

TEST(IpqnThreshold, IsTheLastCrossingOfADenseScan) {
  // numpy: arcs of the sine between quanta, h by recursion, steps of 0.005 in the speed. The last cases are
  // the narrow peaks just above integer speeds.
  EXPECT_NEAR(*ipqn_threshold(autocorrelation(cascade(1, 1)), 0.01), 48.02, 0.01);
  EXPECT_NEAR(*ipqn_threshold(autocorrelation(cascade(1, 3)), 0.1), 14.058, 0.006);
}

TEST(IpqnThreshold, IsNotBelowTheResultOfACoarseScan) {
  // Last peak speed outside 10 % and 1 % on a coarse grid of speeds to 200.
  const struct {
    int d, n;
    double ten, one;
  } rows[] = {{1, 1, .11, 25}, {1, 2, 2.1, 159}, {1, 3, 9.0, 200}, {2, 2, .14, 42}, {2, 3, .22, 114}};
  for (const auto& row : rows) {
    const Autocorrelation a = autocorrelation(cascade(row.d, row.n));
    EXPECT_GE(*ipqn_threshold(a, 0.1), row.ten - 0.005) << row.d << row.n;
    EXPECT_LE(*ipqn_threshold(a, 0.1), 1.6 * row.ten) << row.d << row.n;
    EXPECT_GE(*ipqn_threshold(a, 0.01), row.one - 0.5) << row.d << row.n;
  }
  EXPECT_NEAR(*ipqn_threshold(autocorrelation(cascade(1, 1)), 0.1), .11, .006);
  EXPECT_NEAR(*ipqn_threshold(autocorrelation(cascade(1, 2)), 0.1), 2.1, .06);
}

TEST(IpqnThreshold, IsExceededByNoSpeedAboveIt) {
  for (const auto& [d, n, cutoff] : {std::tuple{1, 1, 50.}, {1, 2, 50.}, {2, 3, 200.}, {1, 2, 10.}}) {
    const Autocorrelation a = autocorrelation(cascade(d, n, cutoff));
    const double threshold = *ipqn_threshold(a, 0.1);
    EXPECT_NEAR(std::abs(slow_sine_sigma(a, threshold) / ipqn_sigma(a) - 1), 0.1, 3e-5);
    for (int i = 0; i < 2000; ++i) {
      const double v =
          threshold * (1 + 1e-6 + 3 * unit_interval(random_bits(7, static_cast<std::uint64_t>(i), 0)));
      EXPECT_LE(std::abs(slow_sine_sigma(a, v) / ipqn_sigma(a) - 1), 0.1 + 3e-5) << d << n << ' ' << v;
    }
  }
}

/// A memory too long for the autocorrelation. At V = p/q the error of an explicit quantizer has a period of q
/// samples; its Fourier coefficients and the frequency response give the output without a formula for sigma.
TEST(ConstantSpeed, OfAVerySlowFilterIsComputedFromItsHarmonics) {
  const Filter slow = cascade(1, 2, 1e-4);  // 1e-7 of the sample rate
  ASSERT_FALSE(autocorrelation_within(slow));
  EXPECT_NEAR(constant_speed_sigma(slow, 3), 0, 1e-12 * h2_norm(slow));
  for (const auto& [p, q] : {std::pair{1, 2}, {2, 3}, {3, 10}, {17, 64}}) {
    std::vector<double> error;
    for (int k = 0; k < q; ++k) {
      const double x = 0.123 / q + k * static_cast<double>(p) / q;
      error.push_back(std::floor(x + 0.5) - x);
    }
    double sum = 0;
    for (int m = 1; m < q; ++m) {
      std::complex<double> c = 0;
      for (int k = 0; k < q; ++k)
        c += error[static_cast<std::size_t>(k)] * std::polar(1.0 / q, -2 * pi * m * k / q);
      sum += std::norm(c * response(slow, 1000.0 * m / q));
    }
    EXPECT_NEAR(constant_speed_sigma(slow, 5 + static_cast<double>(p) / q) / std::sqrt(sum), 1, 1e-9) << q;
  }
  const double irrational = constant_speed_sigma(slow, phi), ipqn = h2_norm(slow) / std::sqrt(12.0);
  EXPECT_GT(irrational, 0);
  EXPECT_LT(irrational, 0.1 * ipqn);  // far from a whole number little passes
}

}  // namespace
}  // namespace qerr
