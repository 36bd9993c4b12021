#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "qerr/core/double_double.hpp"

namespace qerr {

/// A polynomial in q = z^-1 with its zeros at q = 1 divided out: c(q) = (1 - q)^zeros * quotient(q).
template <class T>
struct Deflated {
  int zeros = 0;
  std::vector<T> quotient;
};

/// Sum of the coefficients: the value at q = 1.
template <class T>
T sum(const std::vector<T>& coefficients) {
  T total(0);
  for (const T& c : coefficients) total += c;
  return total;
}

/// Divides out the zeros at q = 1 within the rounding of the coefficients; with `rounding` 0, the exact ones.
///
/// For example, 0.1 + 0.2 q - 0.3 q^2 sums to 2.8e-17 in double precision, but is meant to block 0 Hz.
/// @param rounding  of a coefficient, relative
template <class T, class Coefficient>
Deflated<T> divide_out_dc_zeros(const std::vector<Coefficient>& ascending,
                                double rounding = 0.5 * std::numeric_limits<double>::epsilon()) {
  Deflated<T> result;
  result.quotient.assign(ascending.begin(), ascending.end());
  // Bound of the rounding of every coefficient; each division by (1 - q) accumulates it.
  std::vector<double> bounds;
  for (const Coefficient& c : ascending) bounds.push_back(rounding * std::abs(static_cast<double>(c)));
  while (result.quotient.size() > 1) {
    const T remainder = sum(result.quotient);
    if (T(sum(bounds)) < (remainder < T(0) ? T(-remainder) : remainder)) break;
    for (std::size_t k = 1; k < result.quotient.size(); ++k) {
      result.quotient[k] += result.quotient[k - 1];
      bounds[k] += bounds[k - 1];
    }
    result.quotient.pop_back();
    bounds.pop_back();
    ++result.zeros;
  }
  return result;
}

using Complex1024 = ComplexOf<Binary1024>;

/// All roots of c0 z^n + c1 z^(n-1) + ... + cn, c0 and cn not 0, by the iteration of Ehrlich and Aberth: in
/// double until that converges, then with 1024 bits.
///
/// Conjugate pairs are adjacent, upper half plane first; real roots have im = 0. Simple roots have hundreds
/// of correct digits; an m-fold one becomes m roots on a circle of relative radius 2^(-1000/m), whose product
/// is as accurate as that of simple ones. Nothing is proven: callers that need a proof multiply the factors
/// out.
std::vector<Complex1024> roots(const std::vector<Binary1024>& descending);

long double magnitude(const Complex1024&);

}  // namespace qerr
