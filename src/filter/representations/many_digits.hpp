#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <vector>

#include "qerr/core/double_double.hpp"

/// Arithmetic of 400 digits: twenty poles at 1e-9 from z = 1 take 180 of them.
namespace qerr::many_digits {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<400>, boost::multiprecision::et_off>;
using Vector = std::vector<Real>;

struct Complex {
  Real re, im;
  friend Complex operator+(const Complex& x, const Complex& y) { return {x.re + y.re, x.im + y.im}; }
  friend Complex operator-(const Complex& x, const Complex& y) { return {x.re - y.re, x.im - y.im}; }
  friend Complex operator*(const Complex& x, const Complex& y) {
    return {x.re * y.re - x.im * y.im, x.re * y.im + x.im * y.re};
  }
  friend Complex operator/(const Complex& x, const Complex& y) {
    const Real n = y.re * y.re + y.im * y.im;
    return {(x.re * y.re + x.im * y.im) / n, (x.im * y.re - x.re * y.im) / n};
  }
  Real square() const { return re * re + im * im; }
};

Wide to_wide(const Real&);

/// All roots of a polynomial in ascending powers whose ends are not 0, to 40 digits, by Aberth's iteration.
std::vector<Complex> roots(const Vector& ascending);

}  // namespace qerr::many_digits
