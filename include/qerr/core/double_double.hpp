#pragma once

#include <cmath>

namespace qerr {

/// A number as the unevaluated sum hi + lo of two doubles: about 104 bits (Dekker 1971; Knuth, TAOCP 4.2.2).
///
/// Relative error of + - * / below 2^-100. Needs strict IEEE double arithmetic (no -ffast-math).
struct DoubleDouble {
  double hi = 0;
  double lo = 0;
  constexpr DoubleDouble() = default;
  constexpr DoubleDouble(double value) : hi(value) {}  // NOLINT: exact
  constexpr DoubleDouble(double high, double low) : hi(high), lo(low) {}
  explicit operator double() const { return hi + lo; }
};

/// a + b without error, for |a| >= |b| or a = 0 (Dekker).
inline DoubleDouble quick_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}

/// a + b without error (Knuth).
inline DoubleDouble two_sum(double a, double b) {
  const double s = a + b;
  const double t = s - a;
  return {s, (a - (s - t)) + (b - t)};
}

inline DoubleDouble operator+(DoubleDouble x, DoubleDouble y) {
  DoubleDouble s = two_sum(x.hi, y.hi);
  const DoubleDouble t = two_sum(x.lo, y.lo);
  s = quick_two_sum(s.hi, s.lo + t.hi);
  return quick_two_sum(s.hi, s.lo + t.lo);
}
inline DoubleDouble operator-(DoubleDouble x) { return {-x.hi, -x.lo}; }
inline DoubleDouble operator-(DoubleDouble x, DoubleDouble y) { return x + (-y); }

inline DoubleDouble operator*(DoubleDouble x, DoubleDouble y) {
  const double p = x.hi * y.hi;
  const double e = std::fma(x.hi, y.hi, -p);
  return quick_two_sum(p, e + (x.hi * y.lo + x.lo * y.hi));
}

inline DoubleDouble operator/(DoubleDouble x, DoubleDouble y) {
  const double q1 = x.hi / y.hi;
  DoubleDouble r = x - y * DoubleDouble(q1);
  const double q2 = r.hi / y.hi;
  r = r - y * DoubleDouble(q2);
  const double q3 = r.hi / y.hi;
  return quick_two_sum(q1, q2) + DoubleDouble(q3);
}

/// 2 x, exactly.
inline DoubleDouble twice(DoubleDouble x) { return {2 * x.hi, 2 * x.lo}; }

inline DoubleDouble& operator-=(DoubleDouble& x, DoubleDouble y) { return x = x - y; }
inline DoubleDouble& operator+=(DoubleDouble& x, DoubleDouble y) { return x = x + y; }
inline DoubleDouble& operator*=(DoubleDouble& x, DoubleDouble y) { return x = x * y; }
inline bool operator<(DoubleDouble x, DoubleDouble y) { return x.hi < y.hi || (x.hi == y.hi && x.lo < y.lo); }
inline bool operator==(DoubleDouble x, DoubleDouble y) { return x.hi == y.hi && x.lo == y.lo; }
inline DoubleDouble abs(DoubleDouble x) { return x < DoubleDouble(0) ? -x : x; }

/// Square root of x >= 0: one Newton step from the double root.
inline DoubleDouble sqrt(DoubleDouble x) {
  if (!(DoubleDouble(0) < x)) return 0;
  const double r = std::sqrt(x.hi);
  return DoubleDouble(r) + (x - DoubleDouble(r) * DoubleDouble(r)) / DoubleDouble(2 * r);
}

}  // namespace qerr
