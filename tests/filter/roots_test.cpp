#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <vector>

#include "filter/design/polynomial.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using WideList = std::vector<Binary1024>;
using WideRoots = std::vector<Complex1024>;

/// prod (z - r), descending; of complex roots both of each pair.
WideList polynomial_of(const WideRoots& roots) {
  WideRoots p{Complex1024(1.0)};
  for (const Complex1024& r : roots) {
    p.emplace_back(0.0);
    for (std::size_t i = p.size() - 1; i > 0; --i) p[i] = p[i] - r * p[i - 1];
  }
  WideList real;
  for (const Complex1024& c : p) real.push_back(c.re);
  return real;
}

/// The largest distance of a root from the nearest one that was found, which then counts no more.
long double largest_distance(const WideRoots& exact, WideRoots found) {
  long double largest = 0;
  for (const Complex1024& r : exact) {
    const auto nearest = std::min_element(found.begin(), found.end(), [&](const auto& x, const auto& y) {
      return magnitude(x - r) < magnitude(y - r);
    });
    largest = std::max(largest, magnitude(*nearest - r));
    found.erase(nearest);
  }
  return largest;
}

void expect_pairs(const WideRoots& found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].im == 0) continue;
    ASSERT_LT(i + 1, found.size());
    EXPECT_TRUE(found[i].im > 0);
    EXPECT_TRUE(found[i + 1] == conj(found[i]));
    ++i;
  }
}

WideRoots random_roots(testing::Dice& dice, std::size_t count, double least, double most) {
  WideRoots roots;
  while (roots.size() < count) {
    const double modulus = least + (most - least) * dice.between(0, 1), angle = dice.between(0, 3.14);
    if (roots.size() + 2 > count || dice.chance(0.3)) {
      roots.emplace_back(Binary1024(dice.chance(0.5) ? modulus : -modulus));
    } else {
      const Complex1024 r{Binary1024(modulus * std::cos(angle)), Binary1024(modulus * std::sin(angle))};
      roots.push_back(r);
      roots.push_back(conj(r));
    }
  }
  return roots;
}

TEST(Roots, OfRandomPolynomialsAreAccurateToNearlyAllBits) {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    testing::Dice dice(7000 + seed);
    const double least = seed % 3 == 0 ? 0.999 : 0.1, most = seed % 3 == 1 ? 30 : 1;
    const std::size_t degree = 1 + dice.below(14);
    const WideRoots exact = random_roots(dice, degree, least, most);
    WideList p = polynomial_of(exact);
    for (Binary1024& c : p) c *= -3;
    const WideRoots found = roots(p);
    ASSERT_EQ(found.size(), exact.size());
    EXPECT_LT(largest_distance(exact, found), 1e-250L) << seed;
    expect_pairs(found);
  }
}

/// The accuracy of a root of multiplicity m is 1/m of the bits.
TEST(Roots, OfMultiplicityAreAsAccurateAsTheirBits) {
  for (const std::size_t times : {2, 3, 4, 6}) {
    WideRoots exact(times, Complex1024(0.75));
    exact.emplace_back(-0.5);
    exact.push_back({Binary1024(0.25), Binary1024(0.5)});
    exact.push_back({Binary1024(0.25), Binary1024(-0.5)});
    const WideRoots found = roots(polynomial_of(exact));
    EXPECT_LT(largest_distance(exact, found), std::pow(1e-250L, 1.0L / static_cast<long double>(times)))
        << times;
    expect_pairs(found);
    Binary1024 sum = 0;  // which cancels the errors of the multiple root
    for (const Complex1024& r : found) sum += r.re;
    EXPECT_LT(std::abs(static_cast<double>(sum - (0.75 * static_cast<double>(times)))), 1e-45) << times;
  }
}

/// z^n = c, and roots within 2^-40 of each other.
TEST(Roots, OfHighDegreeAndCloseOnesAreFound) {
  for (const std::size_t n : {2, 31, 64, 100}) {
    WideList p(n + 1);
    p.front() = 1;
    p.back() = -(1 - 0x1p-20);
    const WideRoots found = roots(p);
    ASSERT_EQ(found.size(), n);
    for (const Complex1024& r : found) {
      Complex1024 power(1.0);
      for (std::size_t i = 0; i < n; ++i) power = power * r;
      EXPECT_LT(magnitude(power - Complex1024(Binary1024(1 - 0x1p-20))), 1e-250L) << n;
    }
    expect_pairs(found);
  }
  const double d = 0x1p-40;
  const WideRoots close{Complex1024(0.5), Complex1024(0.5 + d), Complex1024(0.5 - d), Complex1024(-0.25)};
  EXPECT_LT(largest_distance(close, roots(polynomial_of(close))), 1e-200L);
}

TEST(Roots, OfScaledCoefficientsAreThoseOfThePolynomial) {
  // Coefficients far beyond the range of double: 10^-400 and 10^400 of the usual ones.
  for (const int exponent : {-1400, 1400}) {
    const WideRoots exact{Complex1024(0.5), Complex1024(-0.875), Complex1024(0.25)};
    WideList p = polynomial_of(exact);
    for (Binary1024& c : p) c = ldexp(c, exponent);
    EXPECT_LT(largest_distance(exact, roots(p)), 1e-280L);
  }
  EXPECT_TRUE(roots({}).empty());
  EXPECT_TRUE(roots({Binary1024(3)}).empty());
  EXPECT_EQ(static_cast<double>(roots({Binary1024(2), Binary1024(-3)})[0].re), 1.5);
}

/// c(q) = (1 - q)^zeros quotient(q): the quotient times the factor is c, and its sum is beyond rounding.
TEST(DivideOutDcZeros, LeavesAQuotientThatDoesNotVanishThere) {
  testing::Dice dice(91);
  for (int i = 0; i < 60; ++i) {
    const std::size_t zeros = dice.below(4);
    std::vector<double> c(1 + dice.below(6));
    for (double& x : c) x = std::round(dice.between(-99, 99));
    double value = 0;
    for (const double x : c) value += x;
    if (value == 0) c[0] += 1;
    const std::vector<double> quotient = c;
    for (std::size_t k = 0; k < zeros; ++k) {
      c.push_back(0);
      for (std::size_t j = c.size() - 1; j > 0; --j) c[j] -= c[j - 1];
    }
    for (const double rounding : {0.0, 0x1p-53}) {
      const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(c, rounding);
      EXPECT_EQ(d.zeros, static_cast<int>(zeros)) << i;
      ASSERT_EQ(d.quotient.size(), quotient.size()) << i;
      for (std::size_t k = 0; k < quotient.size(); ++k)
        EXPECT_EQ(static_cast<double>(d.quotient[k]), quotient[k]) << i;
      EXPECT_EQ(static_cast<double>(sum(d.quotient)), value == 0 ? 1 : value);
    }
    if (zeros == 0) continue;
    std::vector<double> off = c;  // by more than rounding
    off[0] += 1;
    EXPECT_EQ(divide_out_dc_zeros<DoubleDouble>(off).zeros, 0) << i;
    std::vector<double> third = c;  // by less
    for (double& x : third) x /= 3;
    EXPECT_GE(divide_out_dc_zeros<DoubleDouble>(third).zeros, 1) << i;
  }
  EXPECT_EQ(divide_out_dc_zeros<DoubleDouble>(std::vector<double>{0}).zeros, 0);
  // The bound is the sum of half a bit of each coefficient.
  for (const auto& [off, zeros] : {std::pair{0x1p-52, 1}, std::pair{0x1p-51, 0}})
    EXPECT_EQ(divide_out_dc_zeros<DoubleDouble>(std::vector<double>{1 + off, -1}).zeros, zeros) << off;
}

}  // namespace
}  // namespace qerr
