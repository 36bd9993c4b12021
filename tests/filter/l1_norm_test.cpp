#include <gtest/gtest.h>

#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/random_filter.hpp"
#include "support/reference_norm.hpp"

namespace qerr {
namespace {

using Number =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;

/// sum |h_k| over `count` terms of the difference equation, in 100 digits, independent of the program.
Number direct_sum(const std::vector<Number>& b, const std::vector<Number>& a, std::size_t count) {
  std::vector<Number> h(count);
  Number total = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (k < b.size()) h[k] = b[k];
    for (std::size_t j = 1; j < a.size() && j <= k; ++j) h[k] -= a[j] * h[k - j];
    h[k] /= a[0];
    total += abs(h[k]);
  }
  return total;
}

std::vector<Number> product(const std::vector<Number>& p, const std::vector<Number>& q) {
  std::vector<Number> r(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = 0; j < q.size(); ++j) r[i + j] += p[i] * q[j];
  return r;
}

void expect_holds(const Interval& i, const Number& exact, double relative_width, const std::string& what) {
  EXPECT_LE(Number(i.lower), exact) << what;
  EXPECT_GE(Number(i.upper), exact) << what;
  EXPECT_LE(i.upper - i.lower, relative_width * i.upper) << what;
}

TEST(L1Norm, OfRandomCascadesContainsTheDirectSumWithin1e12) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const RandomFilter random(seed, 6, 0.02);
    Filter filter = difference_filter(0.5, random.differences);
    std::vector<Number> b{1}, a{1};
    for (const auto& s : random.sections) {
      filter.sections.push_back(section_in_w(s.b, s.a));
      b = product(b, {s.b[0], s.b[1], s.b[2]});
      a = product(a, {s.a[0], s.a[1], s.a[2]});
    }
    for (int i = 0; i < random.differences; ++i) b = product(b, {0.5, -0.5});
    // The response of twelve poles at 0.98 is 1e-25 of its peak after 6000 samples.
    const Number exact = direct_sum(b, a, 6000);
    expect_holds(l1_norm(filter), exact, 1e-12, "seed " + std::to_string(seed));
    std::vector<double> rounded_b, rounded_a;
    for (Number& c : b) rounded_b.push_back(static_cast<double>(c));
    for (Number& c : a) rounded_a.push_back(static_cast<double>(c));
    if (seed % 3 != 0) continue;
    try {
      const Filter expanded = filter_from_coefficients(rounded_b, rounded_a, 1, 0);
      if (poles_max_modulus(expanded) > 0.985) continue;
      expect_holds(
          l1_norm(expanded),
          direct_sum({rounded_b.begin(), rounded_b.end()}, {rounded_a.begin(), rounded_a.end()}, 6000), 1e-12,
          "expanded, seed " + std::to_string(seed));
    } catch (const Error& e) {
      EXPECT_EQ(e.faults().at(0).key, "denominator");
    }
  }
}

TEST(L1Norm, OfASlowResonanceContainsTheDirectSumWithin1e12) {
  for (const double gap : {1e-3, 5e-4}) {
    for (const double angle : {1e-3, 2.0}) {
      const double m = 1 - gap, a1 = -2 * m * std::cos(angle), a2 = m * m;
      for (const double fast : {0.0, 0.9, -0.99}) {
        const Filter filter{
            {section_in_w({1, -1, 0.5}, {1, a1, a2}), section_in_w({1, 0, 0}, {1, -fast, 0})}, 1, 1, 0};
        const Number exact =
            direct_sum({1, -1, 0.5}, product({1, a1, a2}, {1, -fast}), static_cast<std::size_t>(40 / gap));
        expect_holds(l1_norm(filter), exact, 1e-12, std::to_string(gap) + " " + std::to_string(angle));
      }
    }
  }
}

TEST(L1Norm, OfResonancesFarBeyondSummationHasItsClosedForm) {
  for (const int bits : {10, 20, 26, 40, 43}) {
    // 1/(1 + c q^2): h_2k = (-c)^k.
    const double c = 1 - std::ldexp(1.0, -bits);
    expect_holds(l1_norm(filter_from_coefficients({1}, {1, 0, c}, 1, 0)), ldexp(Number(1), bits), 1e-12,
                 "quarter turns, 2^-" + std::to_string(bits));
    if (bits > 26) continue;
    // 1/(1 -+ r q + r^2 q^2): h_k = r^k (1, 1, 0, -1, -1, 0, ...), and with alternating signs.
    const double r = c;
    const Number exact = (1 + Number(r)) / (1 - Number(r) * r * r);
    for (const double sign : {1.0, -1.0})
      expect_holds(l1_norm(filter_from_coefficients({1}, {1, -sign * r, r * r}, 1, 0)), exact, 1e-12,
                   "turns of 60 degrees, 2^-" + std::to_string(bits));
  }
}

/// (1 + b q)/(1 - c q^n): |h| is c^k, |b| c^k, with poles near the n-th roots of 1.
TEST(L1Norm, OfPolesNearTheRootsOfOneHasItsClosedForm) {
  for (const int n : {2, 3, 5, 8})
    for (const int bits : {13, 30, 45})
      for (const double sign : {1.0, -1.0}) {
        std::vector<double> a(static_cast<std::size_t>(n) + 1);
        a.front() = 1;
        a.back() = -sign * (1 - std::ldexp(1.0, -bits));
        expect_holds(l1_norm(filter_from_coefficients({1, 0.5}, a, 1, 0)), ldexp(Number(3), bits - 1), 1e-12,
                     std::to_string(n) + " roots, 2^-" + std::to_string(bits));
      }
}

/// Two equal poles +-p each: 1/(1 - c q^2)^2 has h_2k = (k + 1) c^k, 1/(1 - c)^2 in all.
TEST(L1Norm, OfOppositeDoublePolesHasItsClosedForm) {
  const double p = 1 - 0x1p-16;
  const Number gap = 1 - Number(p) * p;
  expect_holds(l1_norm(filter_from_zeros_and_poles({}, {{p}, {-p}, {p}, {-p}}, 1, 1, 0)), 1 / (gap * gap),
               1e-12, "double");
}

TEST(L1Norm, OfSeveralSlowResonancesOfEqualDampingIsWideAndValid) {
  // 1/(1 - c q^4) has four poles of equal modulus; h_4k = c^k.
  const double c = 1 - 0x1p-30;
  const Interval i = l1_norm(filter_from_coefficients({1}, {1, 0, 0, 0, -c}, 1, 0));
  EXPECT_LE(i.lower, 0x1p30);
  EXPECT_GE(i.upper, 0x1p30);
  EXPECT_GT(i.lower, 0x1p30 * (1 - 1e-9));  // all h_k are positive: the norm is H(1)
  EXPECT_LT(i.upper, 0x1p34);
}

TEST(L1Norm, OfTwoResonancesOfAMillionSamplesContainsTheDirectSum) {
  const double a[2][2] = {{1.2927509377453863, 0.9999835304283305}, {-1.999990621743669, 0.9999906602697118}};
  Filter filter{{}, 1, 1, 0};
  for (const auto& s : a) filter.sections.push_back(section_in_w({1, 0, 0}, {1, s[0], s[1]}));
  const Interval i = l1_norm(filter);
  EXPECT_LE(i.upper - i.lower, 1e-12 * i.upper);
  long double total = 0, y[2][2] = {};
  for (int k = 0; k < 8'000'000; ++k) {  // 37 e-folds of the slower one
    long double x = k == 0 ? 1 : 0;
    for (int j = 0; j < 2; ++j) {
      x -= a[j][0] * y[j][0] + a[j][1] * y[j][1];
      y[j][1] = y[j][0];
      y[j][0] = x;
    }
    total += std::abs(x);
  }
  EXPECT_NEAR(static_cast<double>(total / i.lower), 1, 1e-11);  // as far as extended precision carries
}

TEST(L1Norm, OfAnEllipticLowpassOfHighOrderIsNarrowAndDoesNotDependOnASlowCutoff) {
  // In units of the cut-off the impulse response tends to the analog one as (f0/f)^2; for odd orders only,
  // since even ones have a direct feedthrough.
  const auto norm = [](int order, double cutoff) {
    for (const FilterFamily& f : filter_families()) {
      if (f.name == "elliptic")
        return l1_norm(f.design({0, 1e6, {{"order", order}, {"cutoff", cutoff}, {"ripple", 0.1}}, {}, {}}));
    }
    throw std::runtime_error("no elliptic family");
  };
  for (const int order : {15, 17}) {
    const Interval slow = norm(order, 5), faster = norm(order, 20);
    for (const Interval& i : {slow, faster}) EXPECT_LE(i.upper - i.lower, 1e-12 * i.upper) << order;
    EXPECT_NEAR(slow.lower / faster.lower, 1, 1e-8) << order;
  }
}

TEST(L1Norm, OfAPoleOneTrillionthFromTheUnitCircleIsItsReciprocal) {
  const double a = 1 - 0x1p-40;
  for (const double sign : {1.0, -1.0})
    expect_holds(l1_norm(filter_from_coefficients({1}, {1, -sign * a}, 1, 0)), ldexp(Number(1), 40), 1e-12,
                 "");
}

}  // namespace
}  // namespace qerr
