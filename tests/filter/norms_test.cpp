#include "qerr/filter/norms.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"

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
  long double h2 = 0;
  long double l1 = 0;
};

/// Exact norms, 25 digits; empty if the file is absent.
/// @param columns  of family, discretization, d, n, sample rate, cut-off, H2 and l1
std::vector<Row> read_rows(const std::string& path, const std::array<std::size_t, 8>& columns) {
  std::vector<Row> rows;
  std::ifstream file(std::string(QERR_SOURCE_DIR) + path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<std::string> cell;
    std::stringstream cells(line);
    for (std::string c; std::getline(cells, c, ',');) cell.push_back(c);
    const auto at = [&](std::size_t column) { return cell.at(columns[column]); };
    const std::string family = at(0).starts_with("butter") ? "butterworth" : "first_order";
    const std::string kind = at(1) == "tustin_pw" ? "prewarped" : at(1);
    const double cutoff = at(5).empty() ? 0 : std::stod(at(5));
    rows.push_back({line,
                    designed(family, std::stoi(at(2)), std::stoi(at(3)), std::stod(at(4)), cutoff, kind),
                    std::stold(at(6)), std::stold(at(7))});
  }
  return rows;
}

/// Sample rates to 1 MHz, cut-offs from 0.1 Hz (tests/golden/make_filter_norms.py).
std::vector<Row> golden_norms() {
  return read_rows("/tests/golden/filter_norms.csv", {0, 1, 2, 3, 4, 5, 6, 7});
}

/// 300 more (theory.md, section 2), which are not part of the project.
std::vector<Row> oracle() {
  return read_rows("/../shared/oracle/filter_norms.csv", {0, 0, 1, 2, 3, 4, 5, 6});
}

void expect_exact(const std::vector<Row>& rows) {
  double error = 0, width = 0;
  for (const Row& row : rows) {
    const Norms n = norms(row.filter);
    EXPECT_LT(std::abs(n.h2 / row.h2 - 1), 1e-13) << row.name;
    EXPECT_LE(std::abs(n.h2 - row.h2), n.h2_error + 1e-19L * row.h2) << row.name;  // row.h2 is rounded too
    // Rounding of the family's design, and rounding to double.
    const double allowed =
        row.filter.designed ? 1e-15 * static_cast<double>(1 + row.filter.sections.size()) : 0;
    EXPECT_LT(n.h2_error, (allowed + 3e-16) * n.h2) << row.name;
    EXPECT_GE(n.h2_error, allowed * n.h2) << row.name;
    EXPECT_LE(n.l1.lower, row.l1) << row.name;
    EXPECT_GE(n.l1.upper, row.l1) << row.name;
    EXPECT_LT(n.l1.upper - n.l1.lower, 1e-12 * n.l1.lower) << row.name;
    error = std::max(error, static_cast<double>(std::abs(n.h2 / row.h2 - 1)));
    width = std::max(width, (n.l1.upper - n.l1.lower) / n.l1.lower);
  }
  ::testing::Test::RecordProperty("worst_h2_error", std::to_string(error * 1e15) + "e-15");
  ::testing::Test::RecordProperty("worst_l1_width", std::to_string(width * 1e15) + "e-15");
}

TEST(Norms, OfTheFamiliesAreTheGoldenOnes) {
  const std::vector<Row> rows = golden_norms();
  ASSERT_EQ(rows.size(), 237u);
  expect_exact(rows);
}

TEST(Norms, OfTheFamiliesAreThoseOfTheOracle) {
  const std::vector<Row> rows = oracle();
  if (rows.empty()) GTEST_SKIP() << "the oracle file is not in this checkout";
  expect_exact(rows);
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
  // Paper, Table III: n < d grows as f^(d-n), n = d tends to a value, n > d falls as f^(-1/2).
  const double w0 = 2 * std::numbers::pi * 50, rate = 1e9;
  for (const std::string kind : {"matched", "tustin"}) {
    for (int d = 1; d <= 3; ++d) {
      for (int n = 1; n <= 5; ++n) {
        const double h2 = h2_norm(designed("first_order", d, n, rate, 50, kind));
        const double faster = h2_norm(designed("first_order", d, n, 4 * rate, 50, kind));
        const double power = n < d ? d - n : n == d ? 0 : -0.5;
        EXPECT_NEAR(std::log2(faster / h2) / 2, power, 1e-5) << kind << d << n;
        if (n != d) continue;
        const double binomials[] = {1, 2, 6, 20};  // C(2d, d)
        const double limit = kind == "matched" ? 1 : std::sqrt(binomials[d]) / std::pow(2, d);
        EXPECT_NEAR(h2 / (std::pow(w0, d) * limit), 1, 1e-5) << kind << d << n;
      }
    }
  }
}

TEST(Norms, OfTheVelocityRiseAsThePowerThreeHalvesOfTheCutoff) {
  // Paper, Fig. 8 calls it roughly linear for all orders: that is so for n = 1 only, else d + 1/2.
  for (int n = 1; n <= 5; ++n) {
    const double h2 = h2_norm(designed("first_order", 1, n, 1e6, 1));
    const double higher = h2_norm(designed("first_order", 1, n, 1e6, 4));
    EXPECT_NEAR(std::log2(higher / h2) / 2, n == 1 ? 1 : 1.5, 1e-4) << n;
  }
}

TEST(Norms, OfAFiniteImpulseResponseAreItsSums) {
  const Norms n = norms(filter_from_coefficients({3, -4}, {1}, 100, 0));
  EXPECT_DOUBLE_EQ(n.h2, 5);
  EXPECT_NEAR(n.l1.lower, 7, 1e-13);
  EXPECT_LE(n.l1.lower, 7);
  EXPECT_GE(n.l1.upper, 7);
  EXPECT_DOUBLE_EQ(n.dc_gain, -1);
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
