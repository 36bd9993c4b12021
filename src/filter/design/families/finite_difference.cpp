#include <cmath>

#include "filter/design/families/families.hpp"
#include "qerr/core/double_double.hpp"

namespace qerr {
namespace {

constexpr int max_span = 2000;
constexpr int max_accuracy = 8;

/// (-ln(1 - x))^d = sum_k c_k x^k up to degree d + accuracy - 1: the d-th derivative of the polynomial
/// through d + accuracy points, in back differences x = 1 - z^-m.
std::vector<DoubleDouble> series(int derivative, int accuracy) {
  const std::size_t size = static_cast<std::size_t>(derivative + accuracy);
  std::vector<DoubleDouble> power(size);
  power[0] = 1;
  for (int i = 0; i < derivative; ++i) {
    std::vector<DoubleDouble> next(size);
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t k = 1; j + k < size; ++k)
        next[j + k] += power[j] / DoubleDouble(static_cast<double>(k));
    }
    power = next;
  }
  return power;
}

Filter design(const FilterDesign& wanted) {
  const int span = whole_number(wanted, "span", 1, 1, max_span);
  const int accuracy = whole_number(wanted, "accuracy", 1, 1, max_accuracy);
  const Filter differences = difference_filter(wanted.sample_rate, wanted.derivative);  // checks both
  const std::vector<DoubleDouble> c = series(wanted.derivative, wanted.derivative == 0 ? 1 : accuracy);
  std::vector<DoubleDouble> points(c.size());
  for (std::size_t k = 0; k < c.size(); ++k) {  // x^k = sum_j C(k, j) (-1)^j z^(-m j)
    DoubleDouble binomial = c[k];
    for (std::size_t j = 0; j <= k; ++j) {
      points[j] += binomial;
      binomial =
          -binomial * DoubleDouble(static_cast<double>(k - j)) / DoubleDouble(static_cast<double>(j + 1));
    }
  }
  // c_k is d! |s(k, d)|/k! with Stirling numbers s (Abramowitz and Stegun 24.1.3): times K!/d!, K the largest
  // k, the points are whole numbers below 2^53, which keep zeros at z = 1 and delays exact.
  DoubleDouble common = 1;
  for (std::size_t k = static_cast<std::size_t>(wanted.derivative) + 1; k < c.size(); ++k)
    common *= DoubleDouble(static_cast<double>(k));
  Filter filter{{}, DoubleDouble(1) / common, wanted.sample_rate, wanted.derivative};
  filter.designed = true;
  filter.taps.resize((c.size() - 1) * static_cast<std::size_t>(span) + 1);
  for (std::size_t j = 0; j < c.size(); ++j) {
    filter.taps[j * static_cast<std::size_t>(span)] = std::round(static_cast<double>(points[j] * common));
  }
  for (int i = 0; i < wanted.derivative; ++i)
    filter.gain *= DoubleDouble(wanted.sample_rate) / DoubleDouble(span);
  return filter;
}

}  // namespace

FilterFamily finite_difference_family() {
  return {
      "finite_difference",
      "estimates the derivative itself: ((1 - z^-m)/(m T))^derivative over a span of m samples, late by "
      "derivative m T/2; with more accuracy the derivative of the polynomial through that many points more",
      {key::integer("span", "samples m between the points").otherwise(1).within(1, max_span),
       key::integer("accuracy", "order of the error in T: 1 is the plain difference, 2 has no delay, ...")
           .otherwise(1)
           .within(1, max_accuracy)},
      design};
}

}  // namespace qerr
