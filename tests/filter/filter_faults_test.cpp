#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "filter/norms/autocorrelation.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/measured_texts.hpp"
#include "support/sample_filters.hpp"

/// What every family and representation says to wrong input, and that it takes what lies just within: keys,
/// rules, values found and remedies are those of the program itself (`MeasuredTexts`).
namespace qerr {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();

std::string answer_of_design(const FilterFamily& family, const FilterDesign& design) {
  return testing::answer_to([&] { family.design(design); });
}

/// Names of special values are the same with every standard library.
std::string name_of(double value) {
  return std::isnan(value) ? "nan" : std::isinf(value) ? "inf" : std::to_string(value);
}

/// Around both ends of the range of a parameter, and values that no parameter takes.
std::vector<double> values_around(const Parameter& p) {
  std::set<double> values{-1, 0, 0.5, 1, 1e300, endless};
  if (std::isfinite(p.least)) values.insert({p.least - 1, p.least, p.least + 0.25, p.least + 1});
  if (std::isfinite(p.most)) values.insert({p.most - 1, p.most, p.most + 0.25, p.most + 1});
  std::vector<double> list(values.begin(), values.end());
  list.push_back(not_a_number);
  return list;
}

void expect_answers(const testing::MeasuredTexts& measured, const std::string& start,
                    const FilterFamily& family, const SampleFilter& sample) {
  const FilterDesign good{1, 1000, sample.numbers, sample.choices, {}};
  for (const Parameter& p : family.parameters) {
    const std::string name(p.name);
    FilterDesign without = good;
    without.numbers.erase(name);
    without.choices.erase(name);
    measured.expect(start + "without " + name, answer_of_design(family, without));
    FilterDesign changed = good;
    if (p.kind == Kind::choice) {
      changed.choices[name] = "n\1o";
      measured.expect(start + name + " no", answer_of_design(family, changed));
      for (const std::string& choice : choices_of(p)) {
        changed.choices[name] = choice;
        measured.expect(start + name + ' ' + choice, answer_of_design(family, changed));
      }
      continue;
    }
    for (const double value : values_around(p)) {
      changed.numbers[name] = value;
      measured.expect(start + name + ' ' + name_of(value), answer_of_design(family, changed));
    }
  }
  for (int d = -1; d <= max_derivative + 1; ++d) {
    FilterDesign changed = good;
    changed.derivative = d;
    measured.expect(start + "derivative " + std::to_string(d), answer_of_design(family, changed));
  }
  for (const double rate : {0.0, -1.0, 99.0, 101.0, endless, not_a_number}) {
    FilterDesign changed = good;
    changed.sample_rate = rate;
    measured.expect(start + name_of(rate) + " Hz", answer_of_design(family, changed));
  }
}

TEST(FilterFaults, OfTheFamiliesAreThoseMeasured) {
  const testing::MeasuredTexts measured("filter_faults.txt");
  std::size_t index = 0;
  for (const SampleFilter& sample : sample_filters())
    for (const FilterFamily& family : filter_families())
      if (family.name == sample.family)
        expect_answers(measured, std::to_string(index++) + ' ' + sample.family + ' ', family, sample);
}

using Numbers = std::map<std::string, double>;

TEST(FilterFaults, OfCombinedParametersAreThoseMeasured) {
  const testing::MeasuredTexts measured("filter_faults.txt");
  const std::vector<std::pair<std::string, Numbers>> designs{
      {"alpha_beta", {{"alpha", 1.5}, {"beta", 1}}},
      {"alpha_beta", {{"alpha", 1.5}, {"beta", 0.9999999}}},
      {"alpha_beta", {{"alpha", 2}, {"beta", 0.5}}},
      {"alpha_beta", {{"alpha", 0.5}, {"damping", 0.3333}}},
      {"alpha_beta", {{"alpha", 0.5}, {"damping", 0.3334}}},
      {"alpha_beta", {{"alpha", 2}, {"damping", 1}}},
      {"alpha_beta", {{"alpha", 1.5}, {"damping", 2.9}}},
      {"alpha_beta", {{"alpha", 1.5}, {"damping", 1e6}}},
      {"alpha_beta", {{"alpha", 1.5}, {"damping", 1.1e6}}},
      {"alpha_beta", {{"alpha", 0.5}, {"beta", 0.2}, {"damping", 1}}},
      {"alpha_beta", {{"damping", 1}}},
      {"alpha_beta", {{"tracking_index", 1e15}}},
      {"alpha_beta", {{"tracking_index", 2e15}}},
      {"alpha_beta_gamma", {{"alpha", 0.5}, {"beta", 0.2}, {"gamma", 0.27}}},
      {"alpha_beta_gamma", {{"alpha", 0.5}, {"beta", 0.2}, {"gamma", 0.26}}},
      {"alpha_beta_gamma", {{"alpha", 1.5}, {"beta", 1}, {"gamma", 0.1}}},
      {"alpha_beta_gamma", {{"alpha", 1.5}, {"beta", 0.99}, {"gamma", 0.1}}},
      {"alpha_beta_gamma", {{"alpha", 0.5}, {"tracking_index", 1}}},
      {"alpha_beta_gamma", {{"tracking_index", 2e15}}},
      {"kalman", {{"process_noise", 1e-300}, {"measurement_noise", 1e300}}},
      {"kalman", {{"process_noise", 1e300}, {"measurement_noise", 1e-300}}},
      {"kalman", {{"process_noise", 1e18}, {"measurement_noise", 1e-10}}},
      {"kalman", {{"process_noise", 1}, {"measurement_noise", 1e-20}}},
      {"kalman", {{"measurement_noise", 1}}},
      {"kalman", {{"process_noise", 1}, {"measurement_noise", 1}, {"tracking_index", 1}}},
      {"kalman", {{"tracking_index", 2e15}}},
      {"exponential_moving_average", {{"span", 0.99}}},
      {"exponential_moving_average", {{"span", 1}}},
      {"exponential_moving_average", {{"alpha", 1}}},
      {"exponential_moving_average", {{"time_constant", -1}}},
      {"exponential_moving_average", {{"alpha", 0.5}, {"time_constant", 1}, {"span", 3}}},
      {"elliptic", {{"cutoff", 50}, {"ripple", 40}}},
      {"elliptic", {{"cutoff", 50}, {"ripple", 39.9}}},
      {"elliptic", {{"cutoff", 50}, {"attenuation", 1}}},
      {"elliptic", {{"cutoff", 50}, {"attenuation", 0.9}}},
      {"savitzky_golay", {{"window", 1}}},
      {"savitzky_golay", {{"window", 1}, {"polynomial_order", 0}}},
      {"savitzky_golay", {{"window", 2}, {"polynomial_order", 1}}},
      {"savitzky_golay", {{"window", 3}, {"polynomial_order", 3}}},
      {"savitzky_golay", {{"window", 3}}},
      {"least_squares", {{"window", 1}}},
      {"least_squares", {{"window", 1}, {"polynomial_order", 0}}},
      {"least_squares", {{"window", 2}}},
      {"least_squares", {{"window", 21}, {"polynomial_order", 20}}},
      {"first_order", {}},
      {"first_order", {{"order", 0}, {"cutoff", 10}}}};
  std::size_t index = 0;
  for (const auto& [name, numbers] : designs)
    for (const FilterFamily& family : filter_families())
      if (family.name == name) {
        const std::string start = "combined " + std::to_string(index++) + ' ' + name + ' ';
        for (const int d : {0, 1, 2})
          measured.expect(start + std::to_string(d), answer_of_design(family, {d, 1000, numbers, {}, {}}));
        FilterDesign third{1, 1000, numbers, {}, {}};
        if (name != "kalman") continue;
        third.choices["model"] = "constant_acceleration";
        measured.expect(start + "acceleration", answer_of_design(family, third));
      }
}

Rows column_of(const std::vector<double>& list) {
  Rows rows;
  for (const double x : list) rows.push_back({x});
  return rows;
}

/// `count` real numbers, below 1 and distinct.
Rows many(std::size_t count) {
  Rows rows;
  for (std::size_t i = 0; i < count; ++i)
    rows.push_back({0.9 - 1.8 * static_cast<double>(i) / static_cast<double>(count)});
  return rows;
}

Rows square(std::size_t size, double diagonal) {
  Rows rows(size, std::vector<double>(size));
  for (std::size_t i = 0; i < size; ++i) rows[i][i] = diagonal / static_cast<double>(i + 1);
  return rows;
}

using Values = std::map<std::string, Rows>;

void expect_built(const std::string& name, const std::vector<Values>& list) {
  const testing::MeasuredTexts measured("filter_faults.txt");
  for (const FilterRepresentation& r : filter_representations()) {
    if (r.name != name) continue;
    for (std::size_t i = 0; i < list.size(); ++i)
      measured.expect(name + ' ' + std::to_string(i), testing::answer_to([&] { r.build(list[i], 1000, 1); }));
    for (const double rate : {0.0, -1.0, endless})
      measured.expect(name + " at " + name_of(rate) + " Hz",
                      testing::answer_to([&] { r.build(list[0], rate, 1); }));
    measured.expect(name + " derivative 9", testing::answer_to([&] { r.build(list[0], 1000, 9); }));
    measured.expect(name + " derivative -1", testing::answer_to([&] { r.build(list[0], 1000, -1); }));
  }
}

/// Numerators and denominators; those of the first representation are those of the last, by other names.
std::vector<std::pair<Rows, Rows>> transfer_functions() {
  const Rows one{{1}};
  std::vector<double> shift(257), long_shift(258);
  shift.front() = long_shift.front() = 1;
  shift[3] = long_shift[257] = 0.5;
  return {{one, one},
          {{}, one},
          {one, {}},
          {{{1, 2}}, one},
          {one, {{1}, {1, 2}}},
          {one, {{1}, {}}},
          {{{1}, {not_a_number}}, one},
          {one, {{1}, {endless}}},
          {one, {{0}, {1}}},
          {one, column_of({1, -1})},
          {one, column_of({1, 1})},
          {one, column_of({1, -1 + 0x1p-53})},
          {one, column_of({1, -1 + 0x1p-50})},
          {one, column_of({1, -1 + 0x1p-30})},
          {one, column_of({1, -2, 1})},
          {one, column_of({1, -1.999999, 0.999999000000249})},
          {one, column_of({1, -2.5, 1})},
          {one, column_of({1, 0, 1})},
          {one, column_of({1, 0, -1})},
          {one, column_of({1, 0, 1 - 0x1p-53})},
          {one, column_of({1, 0, 1 - 0x1p-49})},
          {one, column_of({2, -3, 1.1})},
          {{{0}}, column_of({1, -2})},
          {{{0}}, column_of({1, -0.5})},
          {column_of({0, 0, 1}), column_of({1, -0.5, 0, 0})},
          {column_of(shift), column_of({1, -0.5})},
          {column_of(long_shift), column_of({1, -0.5})},
          {one, column_of(shift)},
          {one, column_of(long_shift)},
          {column_of(long_shift), column_of(long_shift)},
          {column_of(long_shift), one},
          {column_of({1, 1}), {{0}}}};
}

TEST(FilterFaults, OfCoefficientsAreThoseMeasured) {
  std::vector<Values> by_numerator, by_ros;
  for (const auto& [b, a] : transfer_functions()) {
    by_numerator.push_back({{"numerator", b}, {"denominator", a}});
    by_ros.push_back({{"b", b}, {"a", a}});
  }
  by_numerator.push_back({{"numerator", column_of({1, 2, 3})}});
  expect_built("coefficients", by_numerator);
  expect_built("ros_transfer_function", by_ros);
}

TEST(FilterFaults, OfSectionsAreThoseMeasured) {
  std::vector<Values> list{{{"sos", {{1, 0, 0, 1, -0.5, 0}}}},
                           {{"sos", {}}},
                           {{"sos", Rows(50, {1, 0, 0, 1, -0.5, 0})}},
                           {{"sos", Rows(51, {1, 0, 0, 1, -0.5, 0})}},
                           {{"sos", {{1, 0, 0, 1, -0.5}}}},
                           {{"sos", {{1, 0, 0, 1, -0.5, 0}, {1, 0, 0, 1, -0.5, 0, 0}}}},
                           {{"sos", {{1, 0, 0, 1, -0.5, 0}, {1, not_a_number, 0, 1, -0.5, 0}}}},
                           {{"sos", {{1, 0, 0, 1, endless, 0}}}},
                           {{"sos", {{1, 0, 0, 0, -0.5, 0}}}}};
  for (const std::vector<double>& a : Rows{{1, -1, 0},
                                           {1, 1, 0},
                                           {2, -3, 0},
                                           {-2, 3, 0},
                                           {-2, 1, 0.1},
                                           {1, -2.5, 1.2},
                                           {1, 0, 1.21},
                                           {1, 0, -1.21},
                                           {1, 0.3, 1},
                                           {-1, 1.9, -0.9},
                                           {1, -1.9, 0.9 + 0x1p-40},
                                           {1, -1 + 0x1p-53, 0},
                                           {1, -1 + 0x1p-51, 0},
                                           {1, -2 + 0x1p-51, 1 - 0x1p-51},
                                           {1, -2 + 0x1p-49, 1 - 0x1p-50},
                                           {4, 0, 4 - 0x1p-40},
                                           {4, 1, 5}})
    list.push_back({{"sos", {{1, 0.5, 0.25, 1, -0.5, 0.1}, {1, 0, 0, a[0], a[1], a[2]}}}});
  expect_built("second_order_sections", list);
}

TEST(FilterFaults, OfZerosAndPolesAreThoseMeasured) {
  std::vector<Values> list{{{"zeros", {{1}}}, {"poles", {{0.5}}}, {"gain", {{2}}}},
                           {},
                           {{"zeros", {{1}}}},
                           {{"zeros", {{1}, {1}}}, {"poles", {{0.5}}}},
                           {{"poles", many(100)}, {"zeros", many(100)}},
                           {{"poles", many(101)}},
                           {{"poles", many(101)}, {"zeros", many(102)}},
                           {{"poles", {{0.5}}}, {"gain", {{not_a_number}}}},
                           {{"poles", {{0.5}}}, {"gain", {{0}}}},
                           {{"poles", {{1.5}}}, {"gain", {{0}}}},
                           {{"poles", {{0.5}}}, {"zeros", {{endless}}}},
                           {{"poles", {{0.5}, {0.5, -endless}}}},
                           {{"poles", {{0.5}, {}}}},
                           {{"poles", {{0.5}, {0.1, 0.2, 0.3}}}},
                           {{"poles", {{0.5}}}, {"zeros", {{0.1, 0.2, 0.3}}}},
                           {{"poles", {{0.5, 0.25}}}},
                           {{"poles", {{0.5, 0.25}, {0.5, 0.25}}}},
                           {{"poles", {{0.5, 0.25}, {0.5, -0.25 - 1e-15}}}},
                           {{"poles", {{0.5, 0.25}, {0.5, -0.25 - 1e-13}}}},
                           {{"poles", {{0.5, 0.25}, {0.5, -0.25}, {0.5, -0.25}}}},
                           {{"poles", {{0.5, 0.25}, {0.5, -0.25}, {0.5, -0.25}, {0.5, 0.25}}}},
                           {{"poles", {{0.5}, {0.6}}}, {"zeros", {{1, 1}, {1, 1}}}},
                           {{"poles", {{0.5}, {0.6}}}, {"zeros", {{1, 1}, {1, -1}}}}};
  for (const std::vector<double>& pole : Rows{{1},
                                              {-1},
                                              {1 - 0x1p-53},
                                              {1 - 0x1p-52},
                                              {1 - 0x1p-51},
                                              {-1 + 0x1p-52},
                                              {-1 + 0x1p-51},
                                              {1.5},
                                              {0.6, 0.8},
                                              {0.6, 0.7999999999999996},
                                              {0.6, 0.7999999999999999},
                                              {-1, 0.5}}) {
    if (pole.size() == 1)
      list.push_back({{"poles", {{0.5}, pole, {0.25}}}});
    else
      list.push_back({{"poles", {{0.5}, pole, {pole[0], -pole[1]}}}});
  }
  list.push_back({{"poles", {{1.5}, {-3}, {0.5}, {2}}}});
  expect_built("zero_pole_gain", list);
}

TEST(FilterFaults, OfStateSpacesAreThoseMeasured) {
  const Rows a{{0.5, 0.25}, {0, 0.5}}, one{{1}}, two{{1}, {1}};
  std::vector<Values> list{{{"A", a}, {"B", two}, {"C", {{1, 2}}}, {"D", {{1}}}},
                           {{"A", a}, {"B", two}, {"C", {{1, 2}}}},
                           {{"A", {}}, {"B", {}}, {"C", {}}},
                           {{"A", {{0.5, 1}}}, {"B", one}, {"C", one}},
                           {{"A", {{0.5, 1}, {1}}}, {"B", two}, {"C", two}},
                           {{"A", {{}}}, {"B", one}, {"C", one}},
                           {{"A", square(20, 0.9)}, {"B", many(20)}, {"C", many(20)}},
                           {{"A", square(21, 0.9)}, {"B", many(21)}, {"C", many(21)}},
                           {{"A", {{1e10}}}, {"B", one}, {"C", one}},
                           {{"A", {{1.1e10}}}, {"B", one}, {"C", one}},
                           {{"A", {{0.5, 1e10}, {0, 0.5}}}, {"B", two}, {"C", two}},
                           {{"A", {{0.5, 9e9}, {0, 0.5}}}, {"B", two}, {"C", two}},
                           {{"A", {{0.5, -9e9}, {0, 0.5}}}, {"B", two}, {"C", two}},
                           {{"A", {{0.5, not_a_number}, {0, 0.5}}}, {"B", two}, {"C", two}},
                           {{"A", a}, {"B", {{1}, {endless}}}, {"C", two}},
                           {{"A", a}, {"B", two}, {"C", {{1, not_a_number}}}},
                           {{"A", a}, {"B", two}, {"C", two}, {"D", {{endless}}}},
                           {{"A", a}, {"B", one}, {"C", two}},
                           {{"A", a}, {"B", {{1, 1}, {1, 1}}}, {"C", two}},
                           {{"A", a}, {"B", {{1}, {1, 1}}}, {"C", two}},
                           {{"A", a}, {"B", two}, {"C", {{1, 2, 3}}}},
                           {{"A", a}, {"B", two}, {"C", {}}},
                           {{"A", a}, {"B", two}, {"C", two}, {"D", {{1, 2}}}},
                           {{"A", a}, {"B", two}, {"C", two}, {"D", {{1}, {2}}}},
                           {{"A", a}, {"B", two}, {"C", two}, {"D", {}}},
                           {{"A", a}, {"B", {{0}, {0}}}, {"C", two}}};
  for (const Rows& unstable :
       {Rows{{1, 0}, {0, 0.5}}, Rows{{0.5, 0}, {0, -1}}, Rows{{1, 1}, {0, 1}}, Rows{{-1, 1}, {0, -1}},
        Rows{{0.6, -0.8}, {0.8, 0.6}}, Rows{{0, -1}, {1, 0}}, Rows{{1 - 0x1p-53, 0}, {0, 0.5}},
        Rows{{1 - 0x1p-52, 0}, {0, 0.5}}, Rows{{1 - 0x1p-51, 0}, {0, 0.5}}, Rows{{1 - 0x1p-51, 16}, {0, 0.5}},
        Rows{{2, 0}, {0, 3}}, Rows{{0.5, 2}, {-2, 0.5}}, Rows{{0, -4}, {0.25, 0}}, Rows{{-1.5, 0}, {0, 1}},
        Rows{{0.9, -0.45}, {0.45, 0.9}}})
    list.push_back({{"A", unstable}, {"B", two}, {"C", two}});
  expect_built("state_space", list);
}

TEST(FilterFaults, OfNormsBeyondTheRangeOfDoubleAreThoseMeasured) {
  const testing::MeasuredTexts measured("filter_faults.txt");
  const auto coefficients = [&](const std::string& name, double b, double a0, double a1) {
    measured.expect("norm of " + name, testing::answer_to([&] {
                      h2_norm(filter_from_coefficients({b}, {a0, a1}, 1, 0));
                    }));
  };
  coefficients("1e308/1e-308", 1e308, 1e-308, -0.5e-308);
  coefficients("1e300", 1e300, 1, -0.5);
  coefficients("1e308 and a slow pole", 1e308, 1, -1 + 1e-6);
  coefficients("1e-300", 1e-300, 1, -0.5);
  coefficients("nothing", 0, 1, -0.5);
  const std::vector<std::pair<std::string, Filter>> filters{{"no gain", {{}, 0, 1, 0}},
                                                            {"large taps", {{}, 1, 1, 0, {1e200, 1e200}}},
                                                            {"1e300 Hz", difference_filter(1e300, 2)},
                                                            {"1e150 Hz", difference_filter(1e150, 2)}};
  for (const auto& named : filters)
    measured.expect("norm of " + named.first, testing::answer_to([&] { h2_norm(named.second); }));
}

TEST(FilterFaults, OfMemoriesTooLongForAnAutocorrelationAreThoseMeasured) {
  const testing::MeasuredTexts measured("filter_faults.txt");
  for (const double gap : {1e-18, 1.7e-6, 1.9e-5, 2.1e-5, 1e-3, 0.5})  // 1e-18: the pole is rounded to 1
    for (const int derivative : {0, 2}) {
      Filter filter = difference_filter(1, derivative);
      filter.sections.push_back({{1, 1, 0}, {1, 2 / gap, 0}});
      std::ostringstream name;
      name << "memory " << gap << ' ' << derivative;
      measured.expect(name.str(), testing::answer_to([&] { autocorrelation(filter); }));
      measured.expect(name.str() + " within 50000", testing::answer_to([&] {
                        if (!autocorrelation_within(filter, 50000))
                          throw Error(Fault{{}, "", "beyond", "", ""});
                      }));
    }
}

}  // namespace
}  // namespace qerr
