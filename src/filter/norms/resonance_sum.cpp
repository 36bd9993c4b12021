#include "filter/norms/resonance_sum.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {
namespace {

/// An integer below 2^500 in magnitude: sums and products are exact in 1024 bits, and so is the floor of a
/// quotient, which is either an integer or at least 1/divisor away from one.
using Integer = Binary1024;

Integer quotient(const Integer& x, const Integer& y) { return floor(x / y); }
Integer modulo(const Integer& x, const Integer& y) { return x - y * quotient(x, y); }

/// The affine map of a word over {up, on}: (p, sum) -> (factor p, sum + share p). Words are multiplied from
/// left to right.
struct Word {
  FineComplex factor{1.0};
  FineComplex share{0.0};
};

Word operator*(const Word& x, const Word& y) { return {x.factor * y.factor, x.share + x.factor * y.share}; }

Word power(Word x, Integer n) {
  Word r;
  while (n > 0) {
    const Integer half = quotient(n, 2);
    if (n != 2 * half) r = r * x;
    x = x * x;
    n = half;
  }
  return r;
}

/// The word of the line (p x + b)/q over 0 < x <= n: for every x first an `up` for each integer that the line
/// has crossed since x - 1, then an `on`; 0 <= b < q. Euclid's algorithm, exchanging up and on.
Word line(const Integer& p, const Integer& q, const Integer& b, const Integer& n, const Word& up,
          const Word& on) {
  if (n == 0) return {};
  if (p >= q) return line(modulo(p, q), q, b, n, up, power(up, quotient(p, q)) * on);
  const Integer crossings = quotient(p * n + b, q);
  if (crossings == 0) return power(on, n);
  const Integer gap = q - b - 1;
  return power(on, quotient(gap, p)) * up * line(q, p, modulo(gap, p), crossings - 1, on, up) *
         power(on, n - quotient(q * crossings - b - 1, p));
}

constexpr int fraction_bits = 200;

/// floor(2^200 x), |x| < 2^50.
Integer fixed_point(Binary256 x) {
  Integer sum = 0;
  while (x != 0) {
    const double part = static_cast<double>(x);
    sum += part;
    x -= part;
  }
  return floor(ldexp(sum, fraction_bits));
}

Binary256 exact(const DoubleDouble& x) { return Binary256(x.hi) + Binary256(x.lo); }

FineBall fine(const RealBall& x) { return FineBall(exact(x.mid()), x.rad()); }

}  // namespace

// x_k = 2 Re(c z^k) has the sign (-1)^floor(k alpha + beta), alpha = arg z/pi, beta = arg(c z^from)/pi + 1/2,
// k counted from `from`. The angles are truncated to 200 bits, and arg c is as uncertain as c: a sign can be
// wrong only where the phase is within that uncertainty of a change of sign. There |x_k| <= 2 |c z^k|
// sin(uncertainty), so that the sum is low by at most twice that over all k.
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end) {
  const FineComplex one(1.0), z = mode.z, c{fine(mode.c[0].re), fine(mode.c[0].im)};
  const FineComplex start = c * power(Word{z, {}}, static_cast<double>(from)).factor;
  const Binary256 pi = pi256();
  // The additional half cycle keeps beta positive; `sign` compensates it.
  const Binary256 alpha = atan2(z.im.mid(), z.re.mid()) / pi;
  const Binary256 beta = atan2(start.im.mid(), start.re.mid()) / pi + 1.5;
  const Integer unit = ldexp(Integer(1), fraction_bits);
  const Integer rise = fixed_point(alpha), offset = fixed_point(beta);
  const Word up{-1.0, 0.0}, on{z, z};
  const double sign = modulo(quotient(offset, unit), 2) == 0 ? -1 : 1;
  const Word all =
      line(rise, unit, modulo(offset, unit), Integer(static_cast<double>(end - from - 1)), up, on);
  const FineBall sum = FineBall(2 * sign) * (start * (one + all.share)).re;
  // The truncation grows to 2^-140 over 2^52 terms; arg(start) is off by less than twice its relative error.
  const long double size = std::hypot(start.re.largest(), start.im.largest());
  const long double uncertainty = 4 * std::max(start.re.rad(), start.im.rad()) + 0x1p-130L * size;
  const double count = std::min(static_cast<double>(end - from), 1.01 / one_minus_modulus(mode.one_minus_z));
  const DoubleDouble rounded = to_double_double(sum.mid());
  const long double error = (sum - FineBall::exactly(rounded)).largest() + 4 * uncertainty * count;
  return RealBall(rounded, static_cast<double>(error) * (1 + 0x1p-50));
}

}  // namespace qerr
