#pragma once

#include <compare>
#include <cstddef>

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

}  // namespace qerr
