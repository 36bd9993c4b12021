#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

Filter designed(const std::string& family, int derivative, int order, double rate, double cutoff,
                const std::string& discretization = "matched") {
  if (order == 0) return difference_filter(rate, derivative);
  for (const FilterFamily& f : filter_families()) {
    if (f.name != family) continue;
    FilterDesign d{derivative, rate, {{"order", order}, {"cutoff", cutoff}}, {}, {}};
    if (family == "first_order") d.choices["discretization"] = discretization;
    return f.design(d);
  }
  throw std::runtime_error("no family " + family);
}

struct Row {
  std::string name;
  Filter filter;
  double h2 = 0;
  long double l1 = 0;
};

/// Exact norms, 25 digits (theory.md, section 2); empty where the file is absent.
std::vector<Row> oracle() {
  std::vector<Row> rows;
#ifdef QERR_SOURCE_DIR
  std::ifstream file(std::string(QERR_SOURCE_DIR) + "/../shared/oracle/filter_norms.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> cell;
    std::stringstream cells(line);
    for (std::string c; std::getline(cells, c, ',');) cell.push_back(c);
    const double cutoff = cell[4].empty() ? 0 : std::stod(cell[4]);
    const std::string family = cell[0] == "butter" ? "butterworth" : "first_order";
    const std::string kind = cell[0] == "tustin_pw" ? "prewarped" : cell[0];
    rows.push_back(
        {line, designed(family, std::stoi(cell[1]), std::stoi(cell[2]), std::stod(cell[3]), cutoff, kind),
         std::stod(cell[5]), std::stold(cell[6])});
  }
#endif
  return rows;
}

TEST(H2Norm, AgreesWithTheOracleTo1e12) {
  const std::vector<Row> rows = oracle();
  if (rows.empty()) GTEST_SKIP() << "the oracle file is not in this checkout";
  double worst = 0;
  for (const Row& row : rows) {
    const double error = std::abs(h2_norm(row.filter) / row.h2 - 1);
    EXPECT_LT(error, 1e-12) << row.name;
    worst = std::max(worst, error);
  }
  RecordProperty("worst_relative_error", std::to_string(worst * 1e15) + "e-15");
}

TEST(L1Norm, ContainsTheOracleWithinAWidthOf1e12) {
  const std::vector<Row> rows = oracle();
  if (rows.empty()) GTEST_SKIP() << "the oracle file is not in this checkout";
  double worst = 0;
  for (const Row& row : rows) {
    const Interval l1 = l1_norm(row.filter);
    EXPECT_LE(static_cast<long double>(l1.lower), row.l1) << row.name;
    EXPECT_GE(static_cast<long double>(l1.upper), row.l1) << row.name;
    EXPECT_LT(l1.upper - l1.lower, 1e-12 * l1.lower) << row.name;
    worst = std::max(worst, (l1.upper - l1.lower) / l1.lower);
  }
  RecordProperty("worst_relative_width", std::to_string(worst * 1e15) + "e-15");
}

TEST(H2Norm, OfOneDifferenceAndOneMatchedPoleHasAClosedForm) {
  for (const double cutoff : {0.001, 0.1, 10.0, 50.0, 499.0}) {
    const double rho = std::tanh(std::numbers::pi * cutoff / 1000);
    const double exact = std::sqrt(4e6 * rho * rho / (1 + rho));
    EXPECT_NEAR(h2_norm(designed("first_order", 1, 1, 1000, cutoff)) / exact, 1, 2e-15);
  }
}

TEST(H2Norm, AgreesWithTheCovarianceExamplesOfMatlab) {
  const Filter a = filter_from_coefficients({0, 2, 1}, {1, 0.2, 0.5}, 10, 0);
  EXPECT_NEAR(5 * h2_norm(a) * h2_norm(a), 30.3167, 5e-5);
  const Filter b = filter_from_coefficients({1, -2.841, 2.875, -1.004}, {1, -2.417, 2.003, -0.5488}, 10, 0);
  EXPECT_NEAR(h2_norm(b), 1.2438, 5e-5);
}

TEST(H2Norm, OfUserCoefficientsOfHighQIsThatOfTheirClosedForm) {
  // Second order, exact coefficients: ||H||^2 = (1 + c)/((1 - c) (1 + c - b)(1 + c + b)), b = -a1, c = a2.
  for (const double gap : {0x1p-4, 0x1p-20, 0x1p-36}) {
    const long double c = 1.0L - gap, b = 1.0L;
    const double exact = static_cast<double>(std::sqrt((1 + c) / ((1 - c) * (1 + c - b) * (1 + c + b))));
    EXPECT_NEAR(h2_norm(filter_from_coefficients({1}, {1, -1, static_cast<double>(c)}, 1, 0)) / exact, 1,
                1e-14);
  }
}

TEST(H2Norm, OfAnExactMultiplePoleIsThatOfTheFamily) {
  // (1 - q/2)^6 has exact coefficients and a sixfold root.
  const std::vector<double> a{1, -3, 3.75, -2.5, 0.9375, -0.1875, 0.015625};
  const Filter user = filter_from_coefficients({0.015625}, a, 1000, 0);
  const double cutoff = std::log(2.0) * 1000 / (2 * std::numbers::pi);
  const Filter family = designed("first_order", 0, 6, 1000, cutoff);
  EXPECT_NEAR(h2_norm(user) / h2_norm(family), 1, 1e-13);
  EXPECT_NEAR(poles_max_modulus(user), 0.5, 1e-4);
  EXPECT_NEAR(l1_norm(user).upper, 1, 1e-12);
}

TEST(Norms, AreHomogeneous) {
  Filter filter = designed("butterworth", 2, 4, 1000, 30);
  const Norms one = norms(filter);
  filter.gain *= -8;
  const Norms eight = norms(filter);
  EXPECT_DOUBLE_EQ(eight.h2, 8 * one.h2);
  EXPECT_NEAR(eight.l1.upper / one.l1.upper, 8, 1e-13);
  EXPECT_EQ(eight.dc_gain, 0);
}

TEST(Norms, OfACoordinateLowPassWithOneSignAreItsDcGain) {
  const Interval l1 = l1_norm(designed("first_order", 0, 5, 1e6, 0.1));
  EXPECT_LE(l1.lower, 1);
  EXPECT_GE(l1.upper, 1);
  EXPECT_LT(l1.upper - l1.lower, 1e-12);
}

TEST(Norms, FollowTableThreeAsTheSampleRateGrows) {
  const double w0 = 2 * std::numbers::pi * 50;
  EXPECT_NEAR(h2_norm(designed("first_order", 1, 1, 1e8, 50)) / w0, 1, 1e-5);
  EXPECT_NEAR(h2_norm(designed("first_order", 2, 2, 1e8, 50, "tustin")) / (w0 * w0 * std::sqrt(6.0) / 4), 1,
              1e-5);
  const double falls =
      h2_norm(designed("first_order", 1, 2, 4e6, 50)) / h2_norm(designed("first_order", 1, 2, 1e6, 50));
  EXPECT_NEAR(falls, 0.5, 1e-3);  // f^(-1/2)
  const double rises =
      h2_norm(designed("first_order", 2, 1, 4e6, 50)) / h2_norm(designed("first_order", 2, 1, 1e6, 50));
  EXPECT_NEAR(rises, 4, 1e-2);  // f^(d - n)
}

TEST(Norms, OfATapFilterAreItsSums) {
  const Norms n = norms(filter_from_coefficients({3, -4}, {1}, 100, 0));
  EXPECT_DOUBLE_EQ(n.h2, 5);
  EXPECT_NEAR(n.l1.lower, 7, 1e-13);
  EXPECT_LE(n.l1.lower, 7);
  EXPECT_GE(n.l1.upper, 7);
  EXPECT_DOUBLE_EQ(n.dc_gain, -1);
}

/// Coefficients of a random stable filter, poles to within `closeness` of the circle.
void random_filter(std::mt19937& random, double closeness, std::vector<double>& b, std::vector<double>& a) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto times = [](const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<double> r(x.size() + y.size() - 1);
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = 0; j < y.size(); ++j) r[i + j] += x[i] * y[j];
    return r;
  };
  a = b = {1};
  const int sections = 1 + static_cast<int>(3 * uniform(random));
  for (int i = 0; i < sections; ++i) {
    const double m = 1 - closeness * (1 + uniform(random)), angle = std::numbers::pi * uniform(random);
    a = times(a, {1, -2 * m * std::cos(angle), m * m});
    if (uniform(random) < 0.5) a = times(a, {1, 1.6 * uniform(random) - 0.8});
    b = times(b, {uniform(random), uniform(random) - 0.5, uniform(random) - 0.5});
  }
}

TEST(Norms, OfRandomFiltersHoldTheirDirectSums) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> a, b;
    random_filter(random, i % 2 == 0 ? 0.2 : 0.01, b, a);
    const Filter filter = filter_from_coefficients(b, a, 1000, 0);
    // The difference equation of the coefficients themselves: nothing shared with the sections.
    std::vector<long double> h(12000);
    long double l1 = 0, squares = 0;
    for (std::size_t k = 0; k < h.size(); ++k) {
      h[k] = k < b.size() ? b[k] : 0;
      for (std::size_t j = 1; j < a.size() && j <= k; ++j) h[k] -= static_cast<long double>(a[j]) * h[k - j];
      l1 += std::abs(h[k]);
      squares += h[k] * h[k];
    }
    const Interval interval = l1_norm(filter);
    // The sections are rounded to double: the norms of the coefficients are met to that rounding.
    EXPECT_LE(interval.lower, static_cast<double>(l1) * (1 + 1e-12)) << i;
    EXPECT_GE(interval.upper, static_cast<double>(l1) * (1 - 1e-12)) << i;
    EXPECT_LT(interval.upper - interval.lower, 1e-12 * interval.upper) << i;
    EXPECT_NEAR(h2_norm(filter) / static_cast<double>(std::sqrt(squares)), 1, 1e-12) << i;
  }
}

TEST(L1Norm, IsNeverBelowTheH2Norm) {
  for (const int order : {1, 5, 12, 20}) {
    for (const double cutoff : {1e-4, 0.03, 7.0, 400.0}) {
      const Filter filter = designed("butterworth", 2, order, 1000, cutoff);
      const Interval l1 = l1_norm(filter);
      EXPECT_GE(l1.lower, h2_norm(filter)) << order << " " << cutoff;
      EXPECT_LT(l1.upper - l1.lower, 1e-12 * l1.upper) << order << " " << cutoff;
    }
  }
}

}  // namespace
}  // namespace qerr
