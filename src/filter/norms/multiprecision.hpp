#pragma once

#include <cmath>
#include <compare>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "qerr/core/double_double.hpp"

namespace qerr {

/// A binary floating-point number with a significand of `bits` bits: + - * / and sqrt are correctly rounded,
/// and the exponent has 32 bits.
///
/// A value of Boost.Multiprecision's cpp_bin_float in place, without allocation. Its headers are expensive,
/// so that multiprecision.cpp alone compiles them, for 256, 1024 and 4096 bits.
template <unsigned bits>
class Binary {
 public:
  Binary(double value = 0);  // NOLINT: exact
  Binary(const Binary&);
  Binary& operator=(const Binary&);
  ~Binary();

  explicit operator double() const;  ///< the nearest one
  explicit operator long double() const;

  Binary operator-() const;
  Binary& operator+=(const Binary& y) { return *this = sum(*this, y); }
  Binary& operator-=(const Binary& y) { return *this = difference(*this, y); }
  Binary& operator*=(const Binary& y) { return *this = product(*this, y); }
  Binary& operator/=(const Binary& y) { return *this = quotient(*this, y); }
  friend Binary operator+(const Binary& x, const Binary& y) { return sum(x, y); }
  friend Binary operator-(const Binary& x, const Binary& y) { return difference(x, y); }
  friend Binary operator*(const Binary& x, const Binary& y) { return product(x, y); }
  friend Binary operator/(const Binary& x, const Binary& y) { return quotient(x, y); }
  friend std::partial_ordering operator<=>(const Binary& x, const Binary& y) { return order(x, y); }
  friend bool operator==(const Binary& x, const Binary& y) { return order(x, y) == 0; }

  friend Binary abs(const Binary& x) { return x < Binary() ? -x : x; }
  friend Binary sqrt(const Binary& x) { return x.square_root(); }
  friend Binary ldexp(const Binary& x, int exponent) { return x.scaled(exponent); }

 private:
  static Binary sum(const Binary&, const Binary&);
  static Binary difference(const Binary&, const Binary&);
  static Binary product(const Binary&, const Binary&);
  static Binary quotient(const Binary&, const Binary&);
  static std::partial_ordering order(const Binary&, const Binary&);  ///< unordered with NaN
  Binary square_root() const;
  Binary scaled(int exponent) const;

  friend struct BinaryStorage;
  alignas(16) std::byte storage_[bits / 8 + 32];
};

extern template class Binary<256>;
extern template class Binary<1024>;
extern template class Binary<4096>;

using Binary256 = Binary<256>;
using Binary1024 = Binary<1024>;

/// The largest integer that is not above x.
Binary1024 floor(const Binary1024& x);

/// Significand in [0.5, 1) and exponent of x.
Binary1024 frexp(const Binary1024& x, int* exponent);

/// Elementary functions, to the last bits of 256.
Binary256 exp(const Binary256&);
Binary256 expm1(const Binary256&);
Binary256 log(const Binary256&);
Binary256 pow(const Binary256& base, const Binary256& exponent);
Binary256 sin(const Binary256&);
Binary256 cos(const Binary256&);
Binary256 sinh(const Binary256&);
Binary256 cosh(const Binary256&);
Binary256 atan2(const Binary256& y, const Binary256& x);
Binary256 pi256();

/// Rounding errors of a number type: an operation is off by at most `unit` times its result, plus `tiny`.
template <class T>
struct RoundingErrors;

/// Joldes, Muller, Popescu (2017), Tight and rigorous error bounds for double-word arithmetic: the algorithms
/// of double_double.hpp are off by at most 10 2^-106, barring underflow of a low word.
template <>
struct RoundingErrors<DoubleDouble> {
  using Radius = double;
  static constexpr Radius unit = 0x1p-102;
  static constexpr Radius tiny = 1e-285;
  static Radius magnitude(const DoubleDouble& x) { return std::abs(x.hi) * (1 + 0x1p-50); }
  static DoubleDouble scaled(const DoubleDouble& x, int exponent) {
    return {std::ldexp(x.hi, exponent), std::ldexp(x.lo, exponent)};
  }
};

template <unsigned bits>
struct RoundingErrors<Binary<bits>> {
  using Radius = long double;
  static inline const Radius unit = std::ldexp(1.0L, -static_cast<int>(bits) + 1);
  static constexpr Radius tiny = 0;
  static Radius magnitude(const Binary<bits>& x) {
    return std::abs(static_cast<Radius>(x)) * (1 + 0x1p-50L) + std::numeric_limits<Radius>::min();
  }
  static Binary<bits> scaled(const Binary<bits>& x, int exponent) { return ldexp(x, exponent); }
};

inline Binary1024 to_binary1024(DoubleDouble x) { return Binary1024(x.hi) + Binary1024(x.lo); }

template <unsigned bits>
DoubleDouble to_double_double(const Binary<bits>& x) {
  const double hi = static_cast<double>(x);
  return {hi, static_cast<double>(x - Binary<bits>(hi))};
}

/// Midpoint-radius interval arithmetic: a real number x with |x - mid| <= rad.
///
/// Every operation adds a bound of its own rounding error to the radius, so that a result in balls is a
/// proof. Radii are rounded up by the factor `up`, far more than the few roundings of one radius. With a NaN
/// `above_zero` and `below_zero` are false.
template <class T>
class Ball {
 public:
  using Radius = typename RoundingErrors<T>::Radius;

  Ball() = default;
  Ball(double exact) : mid_(exact) {}  // NOLINT: exact
  explicit Ball(T mid, Radius rad = 0) : mid_(std::move(mid)), rad_(rad) {}
  static Ball exactly(DoubleDouble x) {
    if constexpr (std::is_same_v<T, DoubleDouble>) {
      return Ball(x);
    } else {
      return Ball(T(x.hi) + T(x.lo));
    }
  }

  const T& mid() const { return mid_; }
  Radius rad() const { return rad_; }
  Radius largest() const { return (magnitude() + rad_) * up; }                 ///< of |x|
  Radius smallest() const { return magnitude() * (1 - 0x1p-48) - rad_ * up; }  ///< of |x|; may be below 0
  bool above_zero() const { return T(0) < mid_ && smallest() > 0; }
  bool below_zero() const { return mid_ < T(0) && smallest() > 0; }
  Ball scaled(int exponent) const {
    return Ball(RoundingErrors<T>::scaled(mid_, exponent),
                std::ldexp(rad_, exponent) + RoundingErrors<T>::tiny);
  }

  friend Ball operator-(const Ball& x) { return Ball(-x.mid_, x.rad_); }
  friend Ball operator+(const Ball& x, const Ball& y) { return rounded(x.mid_ + y.mid_, x.rad_ + y.rad_); }
  friend Ball operator-(const Ball& x, const Ball& y) { return rounded(x.mid_ - y.mid_, x.rad_ + y.rad_); }
  friend Ball operator*(const Ball& x, const Ball& y) {
    const Radius spread =
        x.rad_ == 0 && y.rad_ == 0 ? 0 : x.magnitude() * y.rad_ + y.magnitude() * x.rad_ + x.rad_ * y.rad_;
    return rounded(x.mid_ * y.mid_, spread);
  }
  friend Ball operator/(const Ball& x, const Ball& y) {
    Ball q(x.mid_ / y.mid_);
    const Radius divisor = y.smallest();
    const Radius spread = (x.rad_ + q.magnitude() * y.rad_) / divisor;
    return rounded(q.mid_, divisor > 0 ? spread : std::numeric_limits<Radius>::infinity());
  }
  Ball& operator+=(const Ball& y) { return *this = *this + y; }
  Ball& operator-=(const Ball& y) { return *this = *this - y; }
  Ball& operator*=(const Ball& y) { return *this = *this * y; }

  /// @pre x >= 0, though mid - rad may be below 0
  friend Ball sqrt(const Ball& x) {
    using std::sqrt;
    if (!x.above_zero()) return Ball(T(0), sqrt(x.largest()) * up);
    const T root = sqrt(x.mid_);
    return rounded(root, x.rad_ / Ball(root).smallest());
  }
  friend Ball abs(const Ball& x) { return x.mid_ < T(0) ? -x : x; }

 private:
  static constexpr double up = 1 + 0x1p-45;
  Radius magnitude() const { return RoundingErrors<T>::magnitude(mid_); }
  static Ball rounded(T mid, Radius spread) {
    const Radius own = RoundingErrors<T>::unit * RoundingErrors<T>::magnitude(mid);
    return Ball(mid, (spread + own) * up + RoundingErrors<T>::tiny);
  }

  T mid_{};
  Radius rad_ = 0;
};

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
