#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"

namespace qerr {
namespace {

Rows column(const std::vector<double>& list) {
  Rows rows;
  for (const double x : list) rows.push_back({x});
  return rows;
}

Filter built(std::string_view name, const std::map<std::string, Rows>& values) {
  for (const FilterRepresentation& r : filter_representations())
    if (r.name == name) return r.build(values, 1000, 1);
  throw std::runtime_error("no representation " + std::string(name));
}

/// 100 (1 - q)/(1 - 1.6 q + 0.7 q^2), in every representation.
std::map<std::string_view, Filter> one_filter() {
  const double im = std::sqrt(0.06);
  const Rows b = column({100, -100}), a = column({1, -1.6, 0.7});
  return {
      {"coefficients", built("coefficients", {{"numerator", b}, {"denominator", a}})},
      {"second_order_sections", built("second_order_sections", {{"sos", {{100, -100, 0, 1, -1.6, 0.7}}}})},
      {"zero_pole_gain",
       built("zero_pole_gain",
             {{"zeros", {{0}, {1}}}, {"poles", {{0.8, im}, {0.8, -im}}}, {"gain", {{100}}}})},
      {"state_space",
       built("state_space",
             {{"A", {{1.6, -0.7}, {1, 0}}}, {"B", {{1}, {0}}}, {"C", {{60, -70}}}, {"D", {{100}}}})},
      {"ros_transfer_function", built("ros_transfer_function", {{"b", b}, {"a", a}})}};
}

TEST(EveryRepresentation, OfOneFilterIsThatFilter) {
  const auto filters = one_filter();
  ASSERT_EQ(filters.size(), filter_representations().size());
  const Filter reference = filters.at("coefficients");
  const Norms norms_of_reference = norms(reference);
  for (const auto& [name, filter] : filters) {
    const Norms n = norms(filter);
    EXPECT_NEAR(n.h2 / norms_of_reference.h2, 1, 1e-14) << name;
    EXPECT_NEAR(n.l1.upper / norms_of_reference.l1.upper, 1, 1e-13) << name;
    EXPECT_EQ(n.dc_gain, 0) << name;
    EXPECT_NEAR(group_delay(filter), 2.5e-3, 1e-16) << name;
    for (const double f : {1e-6, 1.0, 50.0, 499.0})
      EXPECT_LT(std::abs(response(filter, f) / response(reference, f) - 1.0), 1e-13) << name << f;
  }
}

TEST(EveryRepresentation, IsWithinItsStatedErrorOfMpmath) {
  std::ifstream file(std::string(QERR_SOURCE_DIR) + "/tests/golden/filters.json");
  int count = 0;
  for (const auto& row : nlohmann::json::parse(file)) {
    if (!row.contains("representation")) continue;
    std::map<std::string, Rows> values;
    for (const auto& [key, rows] : row["values"].items()) values[key] = rows.get<Rows>();
    for (const FilterRepresentation& r : filter_representations()) {
      if (r.key.name != row["representation"].get<std::string>()) continue;
      const Estimate e = h2_estimate(r.build(values, 1000, 0));
      const long double exact = std::stold(row["h2"].get<std::string>());
      EXPECT_LE(std::abs(e.value - exact), e.error + 1e-18L * exact) << row["values"];
      EXPECT_LT(e.error, 1e-15 * e.value) << row["values"];
      ++count;
    }
  }
  EXPECT_EQ(count, 64);
}

TEST(StateSpace, OfTwentySlowStatesIsAccurate) {
  // A chain of twenty equal one-pole filters, f0/f about 1e-7: (g/(z - 1 + g))^20 with an exact g.
  const double g = 0x1p-20;
  Rows a(20, std::vector<double>(20)), b(20, {0}), c(1, std::vector<double>(20));
  for (std::size_t i = 0; i < 20; ++i) {
    a[i][i] = 1 - g;
    if (i > 0) a[i][i - 1] = g;
  }
  b[0][0] = g;
  c[0][19] = 1;
  const Filter chain = filter_from_state_space(a, b, c, {{0}}, 1000, 0);
  const Filter same = filter_from_zeros_and_poles({}, Rows(20, {1 - g}), std::pow(g, 20), 1000, 0);
  EXPECT_NEAR(h2_norm(chain) / h2_norm(same), 1, 1e-14);
  EXPECT_NEAR(dc_gain(chain), 1, 1e-14);
  EXPECT_NEAR(dc_gain(same), 1, 1e-14);
}

TEST(ZeroPoleGain, KeepsEqualPolesEqual) {
  const Filter filter =
      filter_from_zeros_and_poles({}, {{0.875}, {0.875}, {0.875}, {0.5, 0.25}, {0.5, -0.25}}, 1, 1000, 0);
  EXPECT_DOUBLE_EQ(poles_max_modulus(filter), 0.875);
  const Interval l1 = l1_norm(filter);
  EXPECT_LT(l1.upper - l1.lower, 1e-12 * l1.upper);
}

TEST(ZeroPoleGain, DelaysByThePolesWithoutZeros) {
  const auto h = impulse_response(filter_from_zeros_and_poles({}, {{0}, {0}, {0.5}}, 2, 1000, 0), 6);
  const std::vector<double> exact{0, 0, 0, 2, 1, 0.5};
  for (std::size_t k = 0; k < h.size(); ++k) EXPECT_NEAR(h[k], exact[k], 1e-15);
}

TEST(Sections, MayBeScalarsAndOfFirstOrder) {
  const Filter filter =
      filter_from_sections({{3, 0, 0, 2, 0, 0}, {1, -1, 0, 1, -0.5, 0}, {1, 2, 1, 1, -0.25, 0}}, 1000, 0);
  const std::complex<double> q = std::polar(1.0, -2 * std::numbers::pi * 0.07);
  const auto exact = 1.5 * (1.0 - q) / (1.0 - 0.5 * q) * (1.0 + 2.0 * q + q * q) / (1.0 - 0.25 * q);
  EXPECT_LT(std::abs(response(filter, 70) - exact), 1e-14);
  EXPECT_DOUBLE_EQ(h2_norm(filter_from_sections({{3, 0, 0, 2, 0, 0}}, 1000, 0)), 1.5);
}

TEST(Sections, ThatNearlyBlockZeroFrequencyBlockIt) {
  const Filter filter = filter_from_sections({{0.1, 0.2, -0.3, 1, -0.5, 0}}, 1000, 1);
  EXPECT_EQ(dc_gain(filter), 0);
  EXPECT_GT(filter.deviation.h2, 0);
}

TEST(Sections, RejectPolesOnTheUnitCircleWithinRounding) {
  const std::vector<std::vector<double>> marginal{{1, -1, 0}, {1, 1, 0},      {1, 0, 1},    {1, -2, 1},
                                                  {1, 2, 1},  {1, -1.9, 0.9}, {1, -0.6, 1}, {1, 0, -1}};
  for (const auto& a : marginal) {
    const Fault fault = refusal([&] {
      filter_from_sections({{1, 0, 0, 1, 0, 0}, {1, 0, 0, a[0], a[1], a[2]}}, 1, 0);
    });
    EXPECT_EQ(fault.key, "sos[1]");
    EXPECT_EQ(fault.found, "largest pole modulus 1");
  }
  EXPECT_NO_THROW(filter_from_sections({{1, 0, 0, 1, -1.999999, 0.999999999}}, 1, 0));
}

TEST(StateSpace, RejectsAnUnstableFilter) {
  const auto tried = [](const Rows& a) {
    return refusal(
        [&] { filter_from_state_space(a, Rows(a.size(), {1}), Rows(a.size(), {1}), {{0}}, 1, 0); });
  };
  EXPECT_EQ(tried({{1}}).found, "largest pole modulus 1");
  EXPECT_EQ(tried({{-1}}).found, "largest pole modulus 1");
  EXPECT_EQ(tried({{1, 0}, {0, 3}}).found, "largest pole modulus 3");
  EXPECT_EQ(tried({{0.6, -0.8}, {0.8, 0.6}}).found, "largest pole modulus 1");
  EXPECT_EQ(tried({{0.5, 1}, {-1, 0.5}}).found, "largest pole modulus 1.11803398875");
}

TEST(ZeroPoleGain, TakesAZeroOneUlpFromOneToBeAtOne) {
  const Rows poles{{0.5}, {0.5}};
  const Filter exact = filter_from_zeros_and_poles({{1}, {-1}}, poles, 25, 200, 1);
  for (const double zero : {1 - 0x1p-53, 1 + 0x1p-52}) {
    const Filter rounded = filter_from_zeros_and_poles({{zero}, {-1}}, poles, 25, 200, 1);
    EXPECT_DOUBLE_EQ(group_delay(rounded), group_delay(exact));
    EXPECT_EQ(dc_gain(rounded), 0);
  }
}

TEST(Representations, OutOfTheRangeOfDoubleAreFaultsOfTheSpec) {
  EXPECT_NEAR(h2_norm(filter_from_coefficients({1e300}, {1, -0.5}, 1, 0)) / (1e300 / std::sqrt(0.75)), 1,
              1e-15);
  try {
    h2_norm(filter_from_coefficients({1e308}, {1e-308, -0.5e-308}, 1, 0));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::input);
  }
}

}  // namespace
}  // namespace qerr
