#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "qerr/core/double_double.hpp"

namespace qerr {

/// A polynomial in q = z^-1 with its zeros at q = 1 divided out: c(q) = (1 - q)^zeros * rest(q).
template <class T>
struct Deflated {
  int zeros = 0;
  std::vector<T> rest;
};

/// Sum of the coefficients: the value at q = 1.
template <class T>
T sum(const std::vector<T>& coefficients) {
  T total(0);
  for (const T& c : coefficients) total += c;
  return total;
}

/// Divides out the zeros at q = 1 that the rounded coefficients cannot tell from exact ones; or, with doubt
/// 0, those that are exact.
///
/// 0.1 + 0.2 q - 0.3 q^2 sums to 2.8e-17 and not to 0; a filter so written is meant to block 0 Hz.
/// @param doubt  what half a unit in the last place is to a coefficient
template <class T>
Deflated<T> divide_out_dc_zeros(const std::vector<double>& ascending,
                                double doubt = 0.5 * std::numeric_limits<double>::epsilon()) {
  Deflated<T> result;
  result.rest.assign(ascending.begin(), ascending.end());
  // What the doubt of every coefficient can do to the sum; each division by (1 - q) sums it up.
  std::vector<double> doubts;
  for (const double c : ascending) doubts.push_back(doubt * std::abs(c));
  while (result.rest.size() > 1) {
    const T remainder = sum(result.rest);
    if (T(sum(doubts)) < (remainder < T(0) ? T(-remainder) : remainder)) break;
    for (std::size_t k = 1; k < result.rest.size(); ++k) {
      result.rest[k] += result.rest[k - 1];
      doubts[k] += doubts[k - 1];
    }
    result.rest.pop_back();
    doubts.pop_back();
    ++result.zeros;
  }
  return result;
}

}  // namespace qerr
