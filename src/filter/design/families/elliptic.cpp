
#include "filter/design/families/families.hpp"
#include "filter/norms/multiprecision.hpp"

namespace qerr {
namespace {

using Complex = ComplexOf<Real>;

ComplexDoubleDouble rounded(const Complex& x) { return {to_double_double(x.re), to_double_double(x.im)}; }

/// theta_2 (odd) or theta_3 at x + jy: sum over the odd or even m >= 0 of 2 q^(m^2/4) cos(m (x + jy)), the
/// term of m = 0 once.
Complex theta(bool odd, const Real& q, const Real& x, const Real& y) {
  Complex sum{0.0, 0.0};
  for (int m = odd ? 1 : 0; m < 400; m += 2) {
    const Real weight = (m == 0 ? 1 : 2) * pow(q, Real(m) * m / 4);
    sum.re += weight * cos(m * x) * cosh(m * y);
    sum.im -= weight * sin(m * x) * sinh(m * y);
    if (weight * cosh(m * y) < 1e-60 * (abs(sum.re) + abs(sum.im))) break;
  }
  return sum;
}

/// K(k)/(pi/2) from the complementary modulus, by the arithmetic-geometric mean.
Real quarter_period(const Real& complementary) {
  Real a = 1, b = complementary;
  for (int i = 0; i < 12; ++i) {
    const Real mean = (a + b) / 2;
    b = sqrt(a * b);
    a = mean;
  }
  return 1 / a;
}

/// Carlson's R_F(x, y, z) = (1/2) int_0^inf dt/sqrt((t + x)(t + y)(t + z)), by duplication (Carlson 1995,
/// Numerical computation of real or complex elliptic integrals, Eq. 2.2): R_F(x, x, x) = 1/sqrt(x).
Real carlson_rf(Real x, Real y, Real z) {
  // Each step divides the differences of the three by four: 60 of them leave 1e-36.
  for (int i = 0; i < 60; ++i) {
    const Real p = sqrt(x), q = sqrt(y), r = sqrt(z), lambda = p * q + q * r + r * p;
    for (Real* number : {&x, &y, &z}) *number = (*number + lambda) / 4;
  }
  return 1 / sqrt(x);
}

/// The elliptic prototype from the nome: the degree equation n K'/K = K1'/K1 reads q = q1^(1/n), and with
/// cd((u - jv) K) = theta_2/(sqrt(k) theta_3) at pi (u - jv)/2 the modulus k itself is not needed.
/// (Orfanidis, Lecture notes on elliptic filter design, 2006, Eqs. 47-56, with theta functions of 77 digits.)
Prototype prototype_of(int order, double ripple, double attenuation) {
  const Real pi = pi256(), ln10 = log(Real(10));
  const Real epsilon2 = expm1(ripple * ln10 / 10);
  const Real k1_squared = epsilon2 / expm1(attenuation * ln10 / 10);
  const Real period = quarter_period(sqrt(1 - k1_squared));
  const Real q = exp(-pi * quarter_period(sqrt(k1_squared)) / period / order);
  const Real root_k = theta(true, q, 0, 0).re / theta(false, q, 0, 0).re;
  // v: sn(j n v K1, k1) = j/epsilon, that is n v K1 = F(atan(1/epsilon), k1').
  const Real cosine2 = epsilon2 / (1 + epsilon2), sine2 = 1 / (1 + epsilon2);
  const Real angle = sqrt(sine2) * carlson_rf(cosine2, cosine2 + k1_squared * sine2, 1);
  const Real y = angle / period / order;  // pi v/2
  // j cd((u - jv) K) up to j: theta at x - jy.
  const auto cd = [&](const Real& x) {
    return rounded(theta(true, q, x, -y) / theta(false, q, x, -y) * Complex(1 / root_k));
  };
  Prototype prototype;
  for (int i = 1; i <= order / 2; ++i) {
    const Real x = pi * (2 * i - 1) / (2 * order);
    const ComplexDoubleDouble p = cd(x);
    prototype.poles.push_back({-abs(p.im), abs(p.re)});
    prototype.zeros.push_back(to_double_double(theta(false, q, x, 0).re / theta(true, q, x, 0).re / root_k));
  }
  if (order % 2 == 1) {
    prototype.poles.push_back(ComplexDoubleDouble(-abs(cd(pi / 2).im)));
  } else {
    prototype.gain = attenuated(ripple);
  }
  return prototype;
}

Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 3, 1, max_order);
  const double ripple = checked_number(wanted, "ripple", 0, 60, 1.0);
  const double attenuation = checked_number(wanted, "attenuation", 0, 300, 40.0);
  if (!(attenuation > ripple)) {
    throw Error("attenuation", "the attenuation must exceed the ripple",
                figure(attenuation) + " dB with a ripple of " + figure(ripple) + " dB",
                "e.g. ripple: 1, attenuation: 40");
  }
  return bilinear_lowpass(wanted, prototype_of(order, ripple, attenuation));
}

}  // namespace

FilterFamily elliptic_family() {
  return {"elliptic",
          "back differences, then an elliptic (Cauer) low-pass with ripple on both sides (bilinear, "
          "pre-warped); even orders start at -ripple, as in scipy and MATLAB",
          {order_row(3), cutoff_row("end of the ripple, below half the sample rate"), ripple_row(),
           attenuation_row("in the stop band, in dB, above the ripple")},
          design};
}

}  // namespace qerr
