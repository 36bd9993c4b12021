#include "filter/norms/multiprecision.hpp"

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <new>

namespace qerr {
namespace {

template <unsigned bits>
using Native = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<bits, boost::multiprecision::digit_base_2>,
    boost::multiprecision::et_off>;

}  // namespace

/// The Boost number within a Binary.
struct BinaryStorage {
  template <unsigned bits>
  static Native<bits>& of(Binary<bits>& x) {
    static_assert(sizeof(Native<bits>) <= sizeof x.storage_ && alignof(Native<bits>) <= 16);
    return *std::launder(reinterpret_cast<Native<bits>*>(x.storage_));
  }
  template <unsigned bits>
  static const Native<bits>& of(const Binary<bits>& x) {
    return *std::launder(reinterpret_cast<const Native<bits>*>(x.storage_));
  }
  template <unsigned bits>
  static Binary<bits> from(const Native<bits>& value) {
    Binary<bits> x;
    of(x) = value;
    return x;
  }
};

namespace {

template <unsigned bits>
const Native<bits>& native(const Binary<bits>& x) {
  return BinaryStorage::of(x);
}
template <unsigned bits>
Binary<bits> binary(const Native<bits>& x) {
  return BinaryStorage::from<bits>(x);
}

}  // namespace

template <unsigned bits>
Binary<bits>::Binary(double value) {
  new (storage_) Native<bits>(value);
}

template <unsigned bits>
Binary<bits>::Binary(const Binary& other) {
  new (storage_) Native<bits>(native(other));
}

template <unsigned bits>
Binary<bits>& Binary<bits>::operator=(const Binary& other) {
  BinaryStorage::of(*this) = native(other);
  return *this;
}

template <unsigned bits>
Binary<bits>::~Binary() {
  using Number = Native<bits>;
  BinaryStorage::of(*this).~Number();
}

template <unsigned bits>
Binary<bits>::operator double() const {
  return static_cast<double>(native(*this));
}

template <unsigned bits>
Binary<bits>::operator long double() const {
  return static_cast<long double>(native(*this));
}

template <unsigned bits>
Binary<bits> Binary<bits>::operator-() const {
  return binary<bits>(-native(*this));
}

template <unsigned bits>
Binary<bits> Binary<bits>::sum(const Binary& x, const Binary& y) {
  return binary<bits>(native(x) + native(y));
}

template <unsigned bits>
Binary<bits> Binary<bits>::difference(const Binary& x, const Binary& y) {
  return binary<bits>(native(x) - native(y));
}

template <unsigned bits>
Binary<bits> Binary<bits>::product(const Binary& x, const Binary& y) {
  return binary<bits>(native(x) * native(y));
}

template <unsigned bits>
Binary<bits> Binary<bits>::quotient(const Binary& x, const Binary& y) {
  return binary<bits>(native(x) / native(y));
}

template <unsigned bits>
std::partial_ordering Binary<bits>::order(const Binary& x, const Binary& y) {
  if (native(x) < native(y)) return std::partial_ordering::less;
  if (native(x) > native(y)) return std::partial_ordering::greater;
  if (native(x) == native(y)) return std::partial_ordering::equivalent;
  return std::partial_ordering::unordered;
}

template <unsigned bits>
Binary<bits> Binary<bits>::square_root() const {
  return binary<bits>(sqrt(native(*this)));
}

template <unsigned bits>
Binary<bits> Binary<bits>::scaled(int exponent) const {
  return binary<bits>(ldexp(native(*this), exponent));
}

template class Binary<256>;
template class Binary<1024>;
template class Binary<4096>;

Binary1024 floor(const Binary1024& x) { return binary<1024>(floor(native(x))); }
Binary1024 frexp(const Binary1024& x, int* exponent) { return binary<1024>(frexp(native(x), exponent)); }

Binary256 exp(const Binary256& x) { return binary<256>(exp(native(x))); }
Binary256 expm1(const Binary256& x) { return binary<256>(expm1(native(x))); }
Binary256 log(const Binary256& x) { return binary<256>(log(native(x))); }
Binary256 pow(const Binary256& base, const Binary256& exponent) {
  return binary<256>(pow(native(base), native(exponent)));
}
Binary256 sin(const Binary256& x) { return binary<256>(sin(native(x))); }
Binary256 cos(const Binary256& x) { return binary<256>(cos(native(x))); }
Binary256 sinh(const Binary256& x) { return binary<256>(sinh(native(x))); }
Binary256 cosh(const Binary256& x) { return binary<256>(cosh(native(x))); }
Binary256 atan2(const Binary256& y, const Binary256& x) { return binary<256>(atan2(native(y), native(x))); }
Binary256 pi256() { return binary<256>(boost::math::constants::pi<Native<256>>()); }

}  // namespace qerr
