#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "filter/frequency_response.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/measured.hpp"

/// Quality of filters against plain computations: every frequency of a fine grid, every sample of a ramp.
namespace qerr {
namespace {

using std::numbers::pi;

Filter of_family(const char* name, int derivative, const std::map<std::string, double>& numbers) {
  for (const FilterFamily& family : filter_families())
    if (family.name == name) return family.design({derivative, 1000, numbers, {}, {}});
  throw std::runtime_error("no such family");
}

struct RatedFilter {
  std::string name;
  Filter filter;
};

/// With and without poles, with many lobes, notches and resonances.
std::vector<RatedFilter> rated_filters() {
  const auto cutoff = [](double order, double hertz) {
    return std::map<std::string, double>{{"order", order}, {"cutoff", hertz}};
  };
  return {{"first order", of_family("first_order", 1, cutoff(1, 20))},
          {"fast average", of_family("exponential_moving_average", 0, {{"alpha", 0.9}})},
          {"two poles", of_family("first_order", 0, cutoff(2, 150))},
          {"Butterworth", of_family("butterworth", 1, cutoff(3, 40))},
          {"elliptic", of_family("elliptic", 0, cutoff(5, 120))},
          {"Chebyshev", of_family("chebyshev1", 2, cutoff(4, 60))},
          {"moving average", filter_from_coefficients(std::vector<double>(40, 0.025), {1}, 1000, 0)},
          {"long average", filter_from_coefficients(std::vector<double>(700, 1.0 / 700), {1}, 1000, 0)},
          {"difference", of_family("finite_difference", 1, {{"span", 60}})},
          {"second difference", of_family("finite_difference", 2, {{"span", 9}, {"accuracy", 2}})},
          {"line", of_family("least_squares", 1, {{"window", 90}})},
          {"parabola", of_family("savitzky_golay", 2, {{"window", 31}})},
          {"tracker", of_family("alpha_beta", 1, {{"tracking_index", 0.02}})},
          {"third order", of_family("alpha_beta_gamma", 2, {{"tracking_index", 0.1}})},
          {"plain difference", difference_filter(1000, 1)}};
}

/// The largest error and the mean square on a grid; the middle of each step (error of the mean h^2/24).
BandTracking on_a_grid(const Filter& filter, double from, double to, int steps) {
  const FrequencyResponse<double> response(filter);
  BandTracking t;
  double squares = 0;
  for (int i = 0; i < steps; ++i) {
    const double f = from + (to - from) * (i + 0.5) / steps;
    const ComplexOf<double> h = response.at(f);
    const std::complex<double> ideal = std::pow(std::complex<double>(0, 2 * pi * f), filter.derivative);
    const double error = std::abs(std::complex<double>(h.re, h.im) / ideal - 1.0);
    squares += error * error;
    t.largest = std::max(t.largest, error);
  }
  for (const double f : {from, to}) t.largest = std::max(t.largest, fidelity(filter, f).tracking_error);
  t.rms = std::sqrt(squares / steps);
  return t;
}

TEST(BandTracking, IsThatOfAFineGrid) {
  const testing::Measured measured("quality_figures.csv", 1e-8);
  for (const RatedFilter& f : rated_filters())
    for (const auto& [from, to] : {std::pair{1.0, 499.0}, std::pair{3.0, 30.0}, std::pair{100.0, 103.0},
                                   std::pair{211.0, 400.0}, std::pair{50.0, 50.001}}) {
      const BandTracking found = band_tracking(f.filter, from, to),
                         grid = on_a_grid(f.filter, from, to, 4000);
      const std::string band = f.name + " from " + std::to_string(from) + " to " + std::to_string(to);
      EXPECT_NEAR(found.rms / grid.rms, 1, 1e-4) << band;
      EXPECT_GE(found.largest, grid.largest * (1 - 1e-12)) << band;
      EXPECT_LE(found.largest, grid.largest * (1 + 1e-3)) << band;
      measured.expect(band + ",largest", found.largest);
      measured.expect(band + ",rms", found.rms);
    }
}

/// The two parts of a band have the mean square of the whole.
TEST(BandTracking, OfABandIsThatOfItsParts) {
  for (const RatedFilter& f : rated_filters())
    for (const auto& [from, to] : {std::pair{2.0, 480.0}, std::pair{20.0, 90.0}}) {
      const double middle = from + 0.377 * (to - from);
      const BandTracking all = band_tracking(f.filter, from, to), low = band_tracking(f.filter, from, middle),
                         high = band_tracking(f.filter, middle, to);
      const double mean =
          (low.rms * low.rms * (middle - from) + high.rms * high.rms * (to - middle)) / (to - from);
      EXPECT_NEAR(all.rms * all.rms / mean, 1, 1e-10) << f.name;
      EXPECT_NEAR(all.largest / std::max(low.largest, high.largest), 1, 1e-10) << f.name;
    }
}

/// Of the response to t^d/d!: the sample after the last one outside, and how far the nearest value is from
/// the threshold.
struct Settled {
  std::size_t samples = 0;
  double margin = 1;
};

Settled by_convolution(const Filter& filter, double fraction, std::size_t count) {
  const std::vector<double> h = impulse_response(filter, count);
  const int d = filter.derivative;
  Settled settled;
  for (std::size_t k = 0; k < count; ++k) {
    long double y = 0;
    for (std::size_t i = 0; i <= k; ++i) {
      long double ramp = 1;
      for (int j = 1; j <= d; ++j) ramp *= static_cast<long double>(k - i) / filter.sample_rate / j;
      y += h[i] * ramp;
    }
    const double error = static_cast<double>(std::abs(y - 1));
    if (error > fraction) settled.samples = k + 1;
    settled.margin = std::min(settled.margin, std::abs(error / fraction - 1));
  }
  return settled;
}

TEST(SettlingTime, IsThatOfAConvolutionForAnyThreshold) {
  int met = 0;
  for (const RatedFilter& f : rated_filters()) {
    if (f.filter.derivative == 2 && f.name != "parabola") continue;  // the sum cancels
    for (const double fraction : {0.5, 0.1, 0.02, 1e-3, 1e-4}) {
      const Settled exact = by_convolution(f.filter, fraction, 900);
      if (exact.margin < 1e-7 || exact.samples > 880) continue;
      const auto found = settling_time(f.filter, fraction);
      if (!found) continue;
      EXPECT_NEAR(*found * 1000, static_cast<double>(exact.samples), 1e-6) << f.name << ' ' << fraction;
      ++met;
    }
  }
  EXPECT_GT(met, 45);
}

/// A slow filter settles as the same one at a higher sample rate: by its samples, and by its modes.
TEST(SettlingTime, OfModesIsThatOfSamples) {
  const testing::Measured measured("quality_figures.csv", 1e-6);
  for (const char* family : {"butterworth", "first_order", "bessel", "chebyshev2"})
    for (const int order : {2, 3, 4})
      for (const int derivative : {0, 1, 2})
        for (const double fraction : {0.3, 0.02, 1e-3, 1e-6}) {
          // 10^4 samples, by samples; 10^5 and 10^7 by modes.
          const double rates[] = {3e4, 1e6, 1e8};
          double times[3];
          for (int i = 0; i < 3; ++i) {
            const auto t = settling_time(design_filter(family, derivative, rates[i], order, 20), fraction);
            times[i] = t.value_or(-1);
            measured.expect(std::string("settling of ") + family + ' ' + std::to_string(order) + ' ' +
                                std::to_string(derivative) + " at " + std::to_string(rates[i]) + " to " +
                                std::to_string(fraction),
                            times[i]);
          }
          // The rates differ by a sample and the bilinear transform; a threshold that a ripple touches, by
          // more.
          EXPECT_NEAR(times[1], times[2], 0.02 * times[2] + 5 / rates[1]) << family << order << fraction;
          EXPECT_NEAR(times[0], times[2], 0.05 * times[2] + 5 / rates[0]) << family << order << fraction;
        }
}

/// Exactly: the last sample of a slow filter outside, and the next one within, by its own samples.
TEST(SettlingTime, OfModesIsExactToASample) {
  for (const double fraction : {0.37, 0.02, 3e-4})
    for (const int derivative : {0, 1}) {
      const Filter f =
          of_family("butterworth", derivative, {{"order", 3}, {"cutoff", 0.45}});  // 21000 samples and more
      const double found = *settling_time(f, fraction) * 1000;
      const std::vector<double> h = impulse_response(f, 30000);
      std::size_t settled = 0;
      long double sum = 0, ramp = 0;
      for (std::size_t k = 0; k < h.size(); ++k) {
        sum += h[k];
        const long double y = derivative == 0 ? sum : ramp;
        ramp += sum / 1000;
        if (std::abs(y - 1) > fraction) settled = k + 1;
      }
      EXPECT_NEAR(found, static_cast<double>(settled), 1e-6) << fraction << ' ' << derivative;
    }
}

/// The first frequency of a fine grid at which |H|/(2 pi f)^d has fallen by 3 dB.
TEST(Bandwidth, IsTheFirstFallOnAFineGrid) {
  const testing::Measured measured("quality_figures.csv", 1e-8);
  int none = 0;
  for (const RatedFilter& f : rated_filters()) {
    const double level = low_frequency_gain(f.filter) / std::numbers::sqrt2;
    const FrequencyResponse<double> response(f.filter);
    double exact = -1;
    for (double at = 0.05; at < 500 && exact < 0; at += 0.05) {
      const ComplexOf<double> h = response.at(at);
      if (std::hypot(h.re, h.im) / std::pow(2 * pi * at, f.filter.derivative) < level) exact = at;
    }
    const double found = bandwidth(f.filter).value_or(-1);
    EXPECT_NEAR(found, exact, 0.051) << f.name;
    none += found < 0;
    measured.expect(f.name + ",bandwidth", found);
    measured.expect(f.name + ",noise bandwidth", noise_bandwidth(f.filter, h2_norm(f.filter)));
    measured.expect(f.name + ",group delay", 1 + group_delay(f.filter));
    measured.expect(f.name + ",gain at 0 Hz", dc_gain(f.filter));
  }
  EXPECT_GT(none, 0);
}

/// cos(pi f T)^n, with n zeros at half the sample rate and nothing else.
TEST(Bandwidth, OfZerosAtHalfTheSampleRateHasItsClosedForm) {
  for (const std::size_t n : {1, 2, 7}) {
    const Filter f{std::vector<Section>(n, {{1, 0, 0}, {1, 1, 0}}), 1, 1000, 0};
    EXPECT_NEAR(*bandwidth(f), 1000 / pi * std::acos(std::pow(0.5, 0.5 / static_cast<double>(n))), 1e-9) << n;
  }
}

/// H/(j 2 pi f)^d near 0 Hz, of filters that pass a lower derivative, a higher one, or none.
TEST(LowFrequencyGain, IsTheLimitOfTheResponse) {
  const auto near_zero = [](const Filter& f) {
    const std::complex<double> s(0, 2 * pi * 1e-7);
    return (response(f, 1e-7) / std::pow(s, f.derivative)).real();
  };
  std::vector<RatedFilter> list = rated_filters();
  list.push_back({"factor 3", filter_from_coefficients({3}, {1, -0.25}, 10, 0)});
  list.push_back({"slope of 2", filter_from_coefficients({2, -2}, {1, -0.25}, 10, 1)});
  list.push_back({"two differences", filter_from_coefficients({1, -2, 1}, {1, -0.25, 0.125}, 10, 2)});
  list.push_back(
      {"three in two sections",
       {{section_in_w({1, -2, 1}, {1, -0.5, 0.25}), section_in_w({-1, 1, 0}, {1, -0.5, 0})}, 3, 20, 3}});
  list.push_back({"taps", filter_from_coefficients({0, 1, -3, 3, -1}, {2}, 10, 3)});
  for (const RatedFilter& f : list) {
    const double gain = low_frequency_gain(f.filter);
    EXPECT_NEAR(gain / near_zero(f.filter), 1, 1e-5) << f.name;
    EXPECT_EQ(estimates_its_derivative(f.filter), gain > 0.5 && gain < 2) << f.name;
    Filter other = f.filter;
    other.derivative += 1;
    EXPECT_TRUE(std::isinf(low_frequency_gain(other))) << f.name;
    EXPECT_FALSE(bandwidth(other)) << f.name;
    EXPECT_FALSE(settling_time(other)) << f.name;
    other.derivative -= 2;
    if (other.derivative >= 0) {
      EXPECT_EQ(low_frequency_gain(other), 0) << f.name;
    }
    other = f.filter;
    for (const double factor : {0.51, 0.49, 1.99, 2.01, -1.0}) {
      other.gain = f.filter.gain * DoubleDouble(factor / gain);
      EXPECT_EQ(estimates_its_derivative(other), factor > 0.5 && factor < 2) << f.name;
    }
  }
}

/// The group delay at 0 Hz is the slope of the phase there.
TEST(GroupDelay, IsTheSlopeOfThePhase) {
  std::vector<RatedFilter> list = rated_filters();
  list.push_back({"delayed taps", filter_from_coefficients({0, 0, 1, 2, 0.5}, {2}, 1000, 0)});
  list.push_back({"zero sum at once", filter_from_coefficients({1, -3, 2}, {1}, 1000, 1)});
  list.push_back({"zeros",
                  {{section_in_w({1, -0.5, 0.25}, {1, -1.5, 0.625}), section_in_w({1, -1, 0}, {1, -0.25, 0})},
                   1,
                   1000,
                   1}});
  list.push_back({"symmetric taps", filter_from_coefficients({-1, 2, -1}, {1}, 1000, 2)});
  for (const RatedFilter& f : list) {
    const double h = 1e-3;
    const std::complex<double> turned =
        response(f.filter, h) / std::pow(std::complex<double>(0, 1), f.filter.derivative);
    const double phase = std::remainder(std::arg(turned), pi);
    EXPECT_NEAR(group_delay(f.filter), -phase / (2 * pi * h), 1e-9 + 1e-6 * std::abs(group_delay(f.filter)))
        << f.name;
  }
}

TEST(Response, OfDoubleDoubleAndDoubleAgreeAtAnyFrequency) {
  const testing::Measured measured("quality_figures.csv", 1e-8);
  for (const RatedFilter& f : rated_filters())
    for (const double at : {1e-9, 0.3, 124.9, 125.1, 250.0, 374.0, 499.99, 500.0}) {
      const Fidelity fine = fidelity(f.filter, at);
      const std::complex<double> ideal = std::pow(std::complex<double>(0, 2 * pi * at), f.filter.derivative);
      const std::complex<double> ratio = response(f.filter, at) / ideal;
      EXPECT_NEAR(fine.gain_error, std::abs(ratio) - 1, 1e-11 * (1 + std::abs(ratio))) << f.name << at;
      EXPECT_NEAR(fine.tracking_error, std::abs(ratio - 1.0), 1e-11 * (1 + std::abs(ratio))) << f.name << at;
      if (std::abs(ratio) > 1e-10) {
        EXPECT_NEAR(std::remainder(fine.phase_error - std::arg(ratio), 2 * pi), 0, 1e-9) << f.name << at;
      }
      if (at < 1)
        measured.expect(f.name + ",tracking error at " + std::to_string(at * 1e9) + " nHz",
                        fine.tracking_error);
      // H is periodic with the sample rate, and conjugate for negative frequencies.
      for (const double same : {at - 1000, at + 2000})
        EXPECT_LT(std::abs(response(f.filter, same) - response(f.filter, at)),
                  1e-6 * std::abs(response(f.filter, at)) + 1e-9)
            << f.name << at;
      EXPECT_LE(std::abs(response(f.filter, -at) - std::conj(response(f.filter, at))),
                1e-12 * std::abs(response(f.filter, at)))
          << f.name << at;
    }
}

TEST(SecondOrderSections, AreThoseOfTheFilter) {
  EXPECT_EQ(second_order_sections({{}, 3, 10, 0}), (std::vector<std::array<double, 6>>{{3, 0, 0, 1, 0, 0}}));
  const Filter f{{section_in_w({1, -0.5, 0.25}, {2, -1.5, 0.5}), section_in_w({1, 0.5, 0}, {1, -0.25, 0}),
                  section_in_w({1, 0.5, 2}, {1, -0.25, 0})},
                 4,
                 10,
                 0};
  const auto found = second_order_sections(f);
  const std::vector<std::array<double, 6>> exact{
      {2, -1, 0.5, 1, -0.75, 0.25}, {1, 0.5, 0, 1, -0.25, 0}, {1, 0.5, 2, 1, -0.25, 0}};
  ASSERT_EQ(found.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found[i][k], exact[i][k], 1e-15) << i << k;
}

}  // namespace
}  // namespace qerr
