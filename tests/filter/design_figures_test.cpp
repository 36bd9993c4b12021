#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "qerr/filter/family.hpp"
#include "support/filter_digits.hpp"
#include "support/measured.hpp"

/// The coefficients of many designs of each family, as the program made them (`Measured`), and what a design
/// makes of parameters that are not given.
namespace qerr {
namespace {

using Numbers = std::map<std::string, double>;
using Choices = std::map<std::string, std::string>;

struct DesignCase {
  std::string family;
  Numbers numbers;
  Choices choices;
  std::vector<int> derivatives;
};

std::vector<DesignCase> low_pass_designs() {
  std::vector<DesignCase> list;
  for (const double order : {1, 2, 3, 4, 5, 8, 20}) {
    const Numbers slow{{"order", order}, {"cutoff", 0.7}}, fast{{"order", order}, {"cutoff", 270}};
    for (const char* kind : {"matched", "tustin", "prewarped", "backward_euler"})
      for (const Numbers& numbers : {slow, fast})
        list.push_back({"first_order", numbers, {{"discretization", kind}}, {0, 2}});
    for (const char* kind : {"phase", "delay", "magnitude"})
      list.push_back({"bessel", fast, {{"normalization", kind}}, {0}});
    for (const char* family : {"butterworth", "chebyshev1", "chebyshev2", "elliptic"})
      for (const Numbers& numbers : {slow, fast}) list.push_back({family, numbers, {}, {0, 1}});
    Numbers strong = fast, weak = fast;
    strong.insert({{"ripple", 3}, {"attenuation", 90}});
    weak.insert({{"ripple", 0.01}, {"attenuation", 15}});
    for (const char* family : {"chebyshev1", "chebyshev2", "elliptic"})
      for (const Numbers& numbers : {strong, weak}) list.push_back({family, numbers, {}, {0}});
  }
  list.push_back({"first_order", {{"order", 0}, {"cutoff", 10}}, {}, {0, 1, 2}});
  return list;
}

std::vector<DesignCase> window_designs() {
  std::vector<DesignCase> list;
  for (const double span : {1, 2, 7})
    for (const double accuracy : {1, 2, 3, 8})
      list.push_back({"finite_difference", {{"span", span}, {"accuracy", accuracy}}, {}, {0, 1, 2, 3, 8}});
  for (const double window : {5, 8, 41}) {
    for (const char* position : {"center", "end"})
      for (const double order : {2, 3, 4})
        list.push_back({"savitzky_golay",
                        {{"window", window}, {"polynomial_order", order}},
                        {{"position", position}},
                        {0, 1, 2}});
    list.push_back({"least_squares", {{"window", window}}, {}, {0, 1, 2, 3}});
  }
  list.push_back({"savitzky_golay", {{"window", 1}, {"polynomial_order", 0}}, {}, {0}});
  list.push_back({"least_squares", {{"window", 30}, {"polynomial_order", 20}}, {}, {0, 8}});
  return list;
}

std::vector<DesignCase> tracker_designs() {
  std::vector<DesignCase> list;
  for (const double index : {1e-9, 1e-3, 0.3, 2.0, 50.0, 1e6}) {
    list.push_back({"alpha_beta", {{"tracking_index", index}}, {}, {0, 1}});
    list.push_back({"alpha_beta_gamma", {{"tracking_index", index}}, {}, {0, 1, 2}});
    const Numbers noise{{"process_noise", index}, {"measurement_noise", 1e-5}};
    for (const Numbers& numbers : {noise, Numbers{{"tracking_index", index}}}) {
      list.push_back({"kalman", numbers, {{"model", "constant_velocity"}}, {0, 1}});
      list.push_back({"kalman", numbers, {{"model", "constant_acceleration"}}, {0, 1, 2}});
    }
  }
  for (const double damping : {0.6, 1.0, 3.0})
    list.push_back({"alpha_beta", {{"alpha", 0.7}, {"damping", damping}}, {}, {0, 1}});
  list.push_back({"alpha_beta", {{"alpha", 0.3}, {"beta", 0.9}}, {}, {0, 1}});
  for (const double gamma : {0.001, 0.1, 0.3})  // poles: real ones and a pair
    list.push_back({"alpha_beta_gamma", {{"alpha", 0.6}, {"beta", 0.3}, {"gamma", gamma}}, {}, {0, 1, 2}});
  for (const double alpha : {1e-6, 0.3, 1.0})
    list.push_back({"exponential_moving_average", {{"alpha", alpha}}, {}, {0, 1, 2}});
  for (const double tau : {1e-5, 2.0})
    list.push_back({"exponential_moving_average", {{"time_constant", tau}}, {}, {0, 1}});
  list.push_back({"exponential_moving_average", {{"span", 9.5}}, {}, {0, 1}});
  return list;
}

std::string name_of(const DesignCase& c) {
  std::ostringstream name;
  name << c.family;
  for (const auto& [key, value] : c.numbers) name << ' ' << key << ' ' << value;
  for (const auto& [key, value] : c.choices) name << ' ' << value;
  return name.str();
}

void expect_designs(const std::vector<DesignCase>& list) {
  const testing::Measured measured("design_figures.csv", 1e-8);
  for (const DesignCase& c : list)
    for (const FilterFamily& family : filter_families())
      if (family.name == c.family)
        for (const int d : c.derivatives) {
          const std::string name = name_of(c) + " d " + std::to_string(d);
          const Filter filter = family.design({d, 1000, c.numbers, c.choices, {}});
          testing::expect_coefficients(measured, name, filter, 3);
          testing::expect_low_digits(measured, name, filter);
        }
}

TEST(DesignFigures, OfLowPassesAreThoseMeasured) { expect_designs(low_pass_designs()); }
TEST(DesignFigures, OfWindowsAreThoseMeasured) { expect_designs(window_designs()); }
TEST(DesignFigures, OfTrackersAreThoseMeasured) { expect_designs(tracker_designs()); }

bool same(const Filter& x, const Filter& y) {
  return x.sections == y.sections && x.gain == y.gain && x.taps == y.taps;
}

/// A parameter that is not given is the default that `qerr list filters` states, a choice the first one.
TEST(EveryFamily, TakesTheDefaultsOfItsRows) {
  int defaults = 0;
  for (const DesignCase& c : {DesignCase{"first_order", {{"cutoff", 50}}, {}, {}},
                              {"butterworth", {{"cutoff", 50}}, {}, {}},
                              {"bessel", {{"cutoff", 50}}, {}, {}},
                              {"chebyshev1", {{"cutoff", 50}}, {}, {}},
                              {"chebyshev2", {{"cutoff", 50}}, {}, {}},
                              {"elliptic", {{"cutoff", 50}}, {}, {}},
                              {"finite_difference", {}, {}, {}},
                              {"savitzky_golay", {{"window", 9}}, {}, {}},
                              {"kalman", {{"tracking_index", 0.1}}, {}, {}}})
    for (const FilterFamily& family : filter_families()) {
      if (family.name != c.family) continue;
      const Filter plain = family.design({1, 1000, c.numbers, {}, {}});
      for (const Parameter& p : family.parameters) {
        FilterDesign given{1, 1000, c.numbers, {}, {}};
        if (p.fallback) given.numbers[std::string(p.name)] = *p.fallback;
        if (p.kind == Kind::choice) given.choices[std::string(p.name)] = choices_of(p).front();
        EXPECT_TRUE(same(plain, family.design(given))) << c.family << ' ' << p.name;
        if (!p.fallback) continue;
        ++defaults;
        given.numbers[std::string(p.name)] = *p.fallback + 1;
        EXPECT_FALSE(same(plain, family.design(given))) << c.family << ' ' << p.name;
      }
    }
  EXPECT_EQ(defaults, 13);
}

TEST(EveryFamily, SaysWhetherItRoundedItsCoefficients) {
  for (const FilterFamily& family : filter_families()) {
    if (family.name != "first_order") continue;
    EXPECT_FALSE(family.design({1, 1000, {{"order", 0}, {"cutoff", 50}}, {}, {}}).designed);
    EXPECT_TRUE(family.design({1, 1000, {{"order", 1}, {"cutoff", 50}}, {}, {}}).designed);
  }
}

}  // namespace
}  // namespace qerr
