#pragma once

#include <cmath>

namespace qerr {

/// A number as the unevaluated sum hi + lo of two doubles: about 104 bits (Dekker 1971; Knuth, TAOCP 4.2.2).
///
/// Relative error of + - * / below 2^-100. Needs strict IEEE double arithmetic (no -ffast-math).
struct Wide {
  double hi = 0;
  double lo = 0;
  constexpr Wide() = default;
  constexpr Wide(double value) : hi(value) {}  // NOLINT: a double is a Wide, exactly
  constexpr Wide(double high, double low) : hi(high), lo(low) {}
  explicit operator double() const { return hi + lo; }
};

inline Wide quick_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

inline Wide two_sum(double a, double b) {
  const double s = a + b;
  const double t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}

inline Wide operator+(Wide x, Wide y) {
  Wide s = two_sum(x.hi, y.hi);
  const Wide t = two_sum(x.lo, y.lo);
  s = quick_two_sum(s.hi, s.lo + t.hi);
  return quick_two_sum(s.hi, s.lo + t.lo);
}
inline Wide operator-(Wide x) { return {-x.hi, -x.lo}; }
inline Wide operator-(Wide x, Wide y) { return x + (-y); }

inline Wide operator*(Wide x, Wide y) {
  const double p = x.hi * y.hi;
  const double e = std::fma(x.hi, y.hi, -p);
  return quick_two_sum(p, e + (x.hi * y.lo + x.lo * y.hi));
}

inline Wide operator/(Wide x, Wide y) {
  const double q1 = x.hi / y.hi;
  Wide r = x - y * Wide(q1);
  const double q2 = r.hi / y.hi;
  r = r - y * Wide(q2);
  const double q3 = r.hi / y.hi;
  return quick_two_sum(q1, q2) + Wide(q3);
}

inline Wide& operator-=(Wide& x, Wide y) { return x = x - y; }
inline Wide& operator+=(Wide& x, Wide y) { return x = x + y; }
inline Wide& operator*=(Wide& x, Wide y) { return x = x * y; }
inline bool operator<(Wide x, Wide y) { return x.hi < y.hi || (x.hi == y.hi && x.lo < y.lo); }
inline bool operator==(Wide x, Wide y) { return x.hi == y.hi && x.lo == y.lo; }
inline Wide abs(Wide x) { return x < Wide(0) ? -x : x; }

/// Square root of x >= 0: one Newton step from the double root.
inline Wide sqrt(Wide x) {
  if (!(Wide(0) < x)) return 0;
  const double r = std::sqrt(x.hi);
  return Wide(r) + (x - Wide(r) * Wide(r)) / Wide(2 * r);
}

}  // namespace qerr
