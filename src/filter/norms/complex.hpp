#pragma once

#include <cmath>

#include "qerr/core/double_double.hpp"

namespace qerr {

/// A complex number over any real type; std::complex is unspecified for others than the built-in types.
template <class T>
struct ComplexOf {
  T re{};
  T im{};
  ComplexOf() = default;
  ComplexOf(T real, T imaginary = T(0)) : re(real), im(imaginary) {}  // NOLINT: exact
  ComplexOf(double real)                                              // NOLINT
      requires(!std::is_same_v<T, double>)
      : re(real), im(0) {}

  friend ComplexOf operator+(const ComplexOf& x, const ComplexOf& y) { return {x.re + y.re, x.im + y.im}; }
  friend ComplexOf operator-(const ComplexOf& x, const ComplexOf& y) { return {x.re - y.re, x.im - y.im}; }
  friend ComplexOf operator-(const ComplexOf& x) { return {-x.re, -x.im}; }
  friend ComplexOf operator*(const ComplexOf& x, const ComplexOf& y) {
    return {x.re * y.re - x.im * y.im, x.re * y.im + x.im * y.re};
  }
  friend ComplexOf operator/(const ComplexOf& x, const ComplexOf& y) {
    const T n = norm(y);
    const ComplexOf p = x * conj(y);
    return {p.re / n, p.im / n};
  }
  friend bool operator==(const ComplexOf& x, const ComplexOf& y) { return x.re == y.re && x.im == y.im; }
  friend T norm(const ComplexOf& x) { return x.re * x.re + x.im * x.im; }
  friend ComplexOf conj(const ComplexOf& x) { return {x.re, -x.im}; }
};

using ComplexDoubleDouble = ComplexOf<DoubleDouble>;
inline double magnitude(const ComplexDoubleDouble& x) { return std::hypot(x.re.hi, x.im.hi); }

}  // namespace qerr
