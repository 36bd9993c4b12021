#include "qerr/filter/filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "support/design_filter.hpp"

namespace qerr {
namespace {

TEST(Filter, OfButterworthIsThreeDecibelsDownAtItsCutoff) {
  for (const int order : {1, 2, 5, 20}) {
    EXPECT_NEAR(std::norm(response(design_filter("butterworth", 0, 1000, order, 30), 30)), 0.5, 1e-13);
    EXPECT_NEAR(std::abs(response(design_filter("butterworth", 0, 1000, order, 30), 500)), 0, 1e-15);
  }
}

TEST(Filter, HasTheMatchedPoleAndImpulseResponse) {
  const Filter filter = design_filter("first_order", 0, 1000, 1, 50);
  const double a = std::exp(-2 * std::numbers::pi * 0.05);
  EXPECT_NEAR(poles_max_modulus(filter), a, 1e-15);
  const auto h = impulse_response(filter, 50);
  for (std::size_t k = 0; k < h.size(); ++k) EXPECT_NEAR(h[k] / ((1 - a) * std::pow(a, k)), 1, 1e-13);
}

TEST(Filter, OfPureDifferencesDelaysByHalfASampleEach) {
  for (int d = 0; d <= max_derivative; ++d) {
    EXPECT_DOUBLE_EQ(group_delay(difference_filter(1000, d)), d * 0.5e-3);
    EXPECT_EQ(poles_max_modulus(difference_filter(1000, d)), 0);
  }
  EXPECT_EQ(impulse_response(difference_filter(1000, 2), 4), (std::vector<double>{1e6, -2e6, 1e6, 0}));
}

TEST(Filter, OfAnImpulseResponseDelaysAndBlocksConstants) {
  const Filter taps = filter_from_coefficients({0, 1, 0, -1}, {2}, 100, 1);
  EXPECT_DOUBLE_EQ(group_delay(taps), 0.02);
  EXPECT_EQ(dc_gain(taps), 0);
}

TEST(Filter, OfCoefficientsHasTheirResponse) {
  const std::vector<double> b{0, 0.3, -0.1, 0.2, 0.05}, a{2, -2.2, 1.3, -0.3};
  const Filter filter = filter_from_coefficients(b, a, 1000, 0);
  for (const double f : {0.0, 1e-3, 10.0, 200.0, 500.0}) {
    std::complex<double> n, d;
    for (std::size_t k = 0; k < b.size(); ++k) {
      const auto q = std::polar(1.0, -2 * std::numbers::pi * f * static_cast<double>(k) / 1000);
      n += b[k] * q;
      if (k < a.size()) d += a[k] * q;
    }
    EXPECT_LT(std::abs(response(filter, f) - n / d), 1e-14) << f;
  }
  EXPECT_NEAR(dc_gain(filter), 0.45 / 0.8, 1e-15);
  EXPECT_NEAR(impulse_response(filter, 2)[1], 0.15, 1e-16);
}

TEST(Filter, OfCoefficientsThatNearlyBlockZeroFrequencyBlocksIt) {
  const Filter filter = filter_from_coefficients({0.1, 0.2, -0.3}, {1, -0.5}, 1000, 1);
  EXPECT_EQ(dc_gain(filter), 0);
  EXPECT_GT(std::abs(response(filter, 1e-9)), 0);
}

TEST(FilterErrors, CoefficientsWithoutMeaning) {
  EXPECT_EQ(refusal([] { filter_from_coefficients({}, {1}, 1, 0); }).key, "numerator");
  EXPECT_EQ(refusal([] { filter_from_coefficients({1}, {}, 1, 0); }).key, "denominator");
  EXPECT_EQ(refusal([] { filter_from_coefficients({1}, {0, 1}, 1, 0); }).key, "denominator");
  EXPECT_EQ(refusal([] { filter_from_coefficients({NAN}, {1}, 1, 0); }).key, "numerator");
}

TEST(FilterErrors, PolesOnOrOutsideTheUnitCircle) {
  EXPECT_EQ(refusal([] {
              filter_from_coefficients({1}, {1, -1.25}, 1, 0);
            }).found,
            "largest pole modulus 1.25");
  EXPECT_EQ(refusal([] { filter_from_coefficients({1}, {1, -1}, 1, 0); }).found, "largest pole modulus 1");
  const std::vector<std::vector<double>> marginal{
      {1, 1}, {1, 0, 1}, {1, -2, 1}, {1, -1.9, 0.9}, {1, -2.3, 1.6, -0.3}, {1, -0.6, 1}, {1, 0, 0, 0, -1}};
  for (const auto& a : marginal) {
    EXPECT_EQ(refusal([&] { filter_from_coefficients({1}, a, 1, 0); }).key, "denominator");
  }
  EXPECT_NO_THROW(filter_from_coefficients({1}, {1, -0.999999999}, 1, 0));
}

}  // namespace
}  // namespace qerr
