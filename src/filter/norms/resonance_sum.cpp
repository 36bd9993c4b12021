#include "filter/norms/resonance_sum.hpp"

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_int.hpp>

namespace qerr {
namespace {

using Integer = boost::multiprecision::int512_t;
using Angle = Binary<256>;
// A complex ball grows by up to the square root of 2 in every product: of 2^50 samples that takes 75 bits.
using Fine = Ball<Angle>;
using FineComplex = ComplexOf<Fine>;

/// What a word does to (p, sum): p -> turn p, sum -> sum + share p. Words are multiplied from left to right.
struct Word {
  FineComplex turn{1.0};
  FineComplex share{0.0};
};

Word operator*(const Word& x, const Word& y) { return {x.turn * y.turn, x.share + x.turn * y.share}; }

Word power(Word x, Integer n) {
  Word r;
  for (; n > 0; n >>= 1) {
    if ((n & 1) != 0) r = r * x;
    x = x * x;
  }
  return r;
}

/// The word of the line (p x + b)/q over 0 < x <= n: at every x first an `up` for each integer the line has
/// passed since x - 1, then an `on`; 0 <= b < q. Euclid's algorithm, exchanging up and on.
Word line(const Integer& p, const Integer& q, const Integer& b, const Integer& n, const Word& up,
          const Word& on) {
  if (n == 0) return {};
  if (p >= q) return line(p % q, q, b, n, up, power(up, p / q) * on);
  const Integer rises = (p * n + b) / q;
  if (rises == 0) return power(on, n);
  const Integer gap = q - b - 1;
  return power(on, gap / p) * up * line(q, p, gap % p, rises - 1, on, up) *
         power(on, n - (q * rises - b - 1) / p);
}

constexpr int fraction_bits = 200;

Integer fixed(const Angle& x) { return static_cast<Integer>(floor(ldexp(x, fraction_bits))); }
Angle exact(const DoubleDouble& x) { return Angle(x.hi) + Angle(x.lo); }

Fine fine(const RealBall& x) { return Fine(exact(x.mid()), x.rad()); }

}  // namespace

// x_k = 2 Re(c z^k) has the sign (-1)^floor(k alpha + beta), alpha = arg z/pi, beta = arg(c z^from)/pi + 1/2,
// k counted from `from`. The angles are cut off after 200 bits and arg c is known as well as c is: a sign can
// be wrong only where the phase is that near to a change of sign, so there |x_k| <= 2 |c z^k| sin(that), and
// the sum is low by twice that over all k, whichever they are.
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end) {
  const FineComplex unity(1.0), w{Fine::exactly(mode.w.re), Fine::exactly(mode.w.im)};
  const FineComplex z = (unity + w) / (unity - w), c{fine(mode.c[0].re), fine(mode.c[0].im)};
  const FineComplex start = c * power(Word{z, {}}, from).turn;
  const Angle pi = boost::math::constants::pi<Angle>(), one = 1;
  const Angle re = exact(mode.w.re), im = exact(mode.w.im);
  // arg z = arg(1 + w) - arg(1 - w). The half turn more keeps beta positive; `sign` takes it back.
  const Angle alpha = (atan2(im, Angle(one + re)) + atan2(im, Angle(one - re))) / pi;
  const Angle beta = atan2(start.im.mid(), start.re.mid()) / pi + Angle(1.5);
  const Integer unit = Integer(1) << fraction_bits;
  const Integer rise = fixed(alpha), offset = fixed(beta);
  const Word up{-1.0, 0.0}, on{z, z};
  const double sign = (offset / unit) % 2 == 0 ? -1 : 1;
  const Word all = line(rise, unit, offset % unit, Integer(end - from - 1), up, on);
  const Fine sum = Fine(2 * sign) * (start * (unity + all.share)).re;
  // The cut-off grows to 2^-140 over 2^52 terms; arg(start) is off by less than twice its relative error.
  const long double size = std::hypot(start.re.largest(), start.im.largest());
  const long double doubt = 4 * std::max(start.re.rad(), start.im.rad()) + 0x1p-130L * size;
  const double count = std::min(static_cast<double>(end - from), 1.01 / one_minus_modulus(mode.one_minus_z));
  const DoubleDouble rounded = to_double_double(sum.mid());
  const long double rest = (sum - Fine::exactly(rounded)).largest() + 4 * doubt * count;
  return RealBall(rounded, static_cast<double>(rest) * (1 + 0x1p-50));
}

}  // namespace qerr
