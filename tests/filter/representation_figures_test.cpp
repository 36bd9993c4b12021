#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/filter_digits.hpp"
#include "support/measured.hpp"
#include "support/random_chain.hpp"

/// Random filters in every representation: against their zeros and poles, and all coefficients, proven
/// deviations and widths as the program computed them (`Measured`).
namespace qerr {
namespace {

using Root = std::complex<double>;

/// Zeros and poles; of complex ones both of a pair.
struct RootsAndGain {
  std::vector<Root> zeros, poles;
  double gain = 1;

  Root at(double frequency, double rate) const {
    const Root z = std::polar(1.0, 2 * std::numbers::pi * frequency / rate);
    Root h = gain;
    for (const Root& r : zeros) h *= z - r;
    for (const Root& r : poles) h /= z - r;
    return h;
  }
};

/// One real number or a conjugate pair; of few digits if `dyadic`, so that sums and products are exact.
std::vector<Root> random_roots(testing::Dice& dice, double largest, bool dyadic) {
  const double kind = dice.between(0, 1), angle = dice.between(0, std::numbers::pi);
  const double modulus = dice.between(0.1, largest);
  const double digits = dyadic ? 64 : 1e9;
  const auto rounded = [&](double x) { return std::round(x * digits) / digits; };
  if (kind < 0.4) return {rounded(kind < 0.1 ? -modulus : modulus)};
  const Root r(rounded(modulus * std::cos(angle)), rounded(modulus * std::sin(angle)));
  if (r.imag() == 0) return {r};
  return kind < 0.7 ? std::vector<Root>{r, std::conj(r)} : std::vector<Root>{std::conj(r), r};
}

/// Up to two zeros are at z = 1, of odd seeds within rounding of it.
RootsAndGain random_filter(std::uint64_t seed) {
  testing::Dice dice(seed);
  const bool dyadic = seed % 3 == 0;
  RootsAndGain f;
  const std::size_t order = 1 + dice.below(6);
  while (f.poles.size() < order)
    for (const Root& r : random_roots(dice, seed % 5 == 1 ? 0.9999 : 0.95, dyadic)) f.poles.push_back(r);
  if (seed % 4 == 1) f.poles.push_back(f.poles[0].imag() == 0 ? f.poles[0] : 0.5);  // a repeated one
  const std::size_t at_dc = dice.below(3), most = f.poles.size() - dice.below(2);
  for (std::size_t i = 0; i < at_dc && f.zeros.size() < most; ++i)
    f.zeros.push_back(seed % 2 == 0 ? 1 : 1 - 0x1p-53);
  while (f.zeros.size() + 2 <= most)
    for (const Root& r : random_roots(dice, 1.3, dyadic)) f.zeros.push_back(r);
  f.gain = dyadic ? 0.75 : 0.125 * static_cast<double>(1 + dice.below(200));
  return f;
}

/// prod (1 - r q), ascending, of real coefficients.
std::vector<double> expanded(const std::vector<Root>& roots) {
  std::vector<Root> p{1};
  for (const Root& r : roots) {
    p.emplace_back(0);
    for (std::size_t i = p.size() - 1; i > 0; --i) p[i] -= r * p[i - 1];
  }
  std::vector<double> real;
  for (const Root& c : p) real.push_back(c.real());
  return real;
}

Rows rows_of(const std::vector<Root>& roots) {
  Rows rows;
  for (const Root& r : roots)
    rows.push_back(r.imag() == 0 ? std::vector<double>{r.real()} : std::vector<double>{r.real(), r.imag()});
  return rows;
}

/// Numerator and denominator in q; the gain and the delay of missing zeros in the numerator.
struct Ratio {
  std::vector<double> b, a;
};

Ratio ratio_of(const RootsAndGain& f) {
  Ratio r{expanded(f.zeros), expanded(f.poles)};
  for (double& c : r.b) c *= f.gain;
  r.b.insert(r.b.begin(), f.poles.size() - f.zeros.size(), 0.0);
  return r;
}

/// Controller canonical form.
std::map<std::string, Rows> state_space_of(const Ratio& r) {
  const std::size_t n = r.a.size() - 1;
  Rows a(n, std::vector<double>(n)), b(n, {0}), c(1, std::vector<double>(n));
  b[0][0] = 1;
  for (std::size_t i = 0; i < n; ++i) {
    a[0][i] = -r.a[i + 1];
    if (i > 0) a[i][i - 1] = 1;
    c[0][i] = r.b[i + 1] - r.b[0] * r.a[i + 1];
  }
  return {{"A", a}, {"B", b}, {"C", c}, {"D", {{r.b[0]}}}};
}

/// Rounded to 2^-30, so that it does not depend on the order of the last roundings.
double in_parts(double x) { return std::ldexp(std::round(std::ldexp(x, 30)), -30); }

/// Second-order sections of the pairs; what is left is in sections of first order.
Rows sections_of(const RootsAndGain& f) {
  const auto parts = [](const std::vector<Root>& roots) {
    std::vector<std::vector<double>> list;
    for (std::size_t i = 0; i < roots.size(); ++i)
      if (roots[i].imag() == 0)
        list.push_back({1, -roots[i].real(), 0});
      else if (i + 1 < roots.size() && roots[i + 1] == std::conj(roots[i]))
        list.push_back({1, -2 * roots[i].real(), in_parts(std::norm(roots[i]))}), ++i;
    return list;
  };
  std::vector<std::vector<double>> above = parts(f.zeros), below = parts(f.poles);
  above.resize(std::max(above.size(), below.size()), {1, 0, 0});
  below.resize(above.size(), {1, 0, 0});
  Rows sos;
  for (std::size_t i = 0; i < above.size(); ++i) {
    sos.push_back(above[i]);
    sos.back().insert(sos.back().end(), below[i].begin(), below[i].end());
  }
  for (std::size_t k = 0; k < 3; ++k) sos[0][k] *= f.gain;
  return sos;
}

void expect_figures(const std::string& name, const Filter& filter) {
  const testing::Measured measured("representation_figures.csv", 1e-8);
  const testing::Measured sizes("representation_figures.csv", 0.004);
  testing::expect_coefficients(measured, name, filter, 3);
  const auto logarithm = [](double x) { return x == 0 ? -999 : std::log2(x); };
  sizes.expect(name + ",h2 of the deviation", logarithm(filter.deviation.h2));
  sizes.expect(name + ",l1 of the deviation", logarithm(filter.deviation.l1));
  const Norms n = norms(filter);
  measured.expect(name + ",h2", n.h2);
  sizes.expect(name + ",error of h2", logarithm(n.h2_error / n.h2));
  sizes.expect(name + ",width of l1", logarithm(n.l1.upper / n.l1.lower - 1));
  measured.expect(name + ",gain at 0 Hz", dc_gain(filter));
  measured.expect(name + ",low-frequency gain", low_frequency_gain(filter));
}

void expect_response(const RootsAndGain& f, const Filter& filter, double tolerance, const std::string& name) {
  for (const double frequency : {3.0, 80.0, 250.0, 440.0}) {
    const Root exact = f.at(frequency, 1000);
    EXPECT_LT(std::abs(response(filter, frequency) - exact), tolerance * std::abs(exact))
        << name << frequency;
  }
}

TEST(RepresentationFigures, OfRandomFiltersAreThoseMeasured) {
  const testing::Measured measured("representation_figures.csv", 1e-8);
  for (std::uint64_t seed = 0; seed < 36; ++seed) {
    const RootsAndGain f = random_filter(4000 + seed);
    const Ratio r = ratio_of(f);
    const std::string name = std::to_string(seed) + ' ';
    const Filter by_roots = filter_from_zeros_and_poles(rows_of(f.zeros), rows_of(f.poles), f.gain, 1000, 1);
    expect_response(f, by_roots, 1e-12, name + "zeros and poles ");
    expect_figures(name + "zeros and poles", by_roots);
    testing::expect_low_digits(measured, name + "zeros and poles", by_roots);
    const RootsAndGain undelayed = [&] {
      RootsAndGain u = f;
      u.zeros.insert(u.zeros.end(), f.poles.size() - f.zeros.size(), 0.0);
      return u;
    }();
    const Filter by_sections = filter_from_sections(sections_of(f), 1000, 1);
    expect_response(undelayed, by_sections, seed % 5 == 1 ? 1e-3 : 1e-6, name + "sections ");
    expect_figures(name + "sections", by_sections);
    testing::expect_low_digits(measured, name + "sections", by_sections);
    if (seed % 5 == 1) continue;  // slow poles: the expanded coefficients are another filter
    const Filter by_coefficients = filter_from_coefficients(r.b, r.a, 1000, 1);
    expect_response(f, by_coefficients, 1e-7, name + "coefficients ");
    expect_figures(name + "coefficients", by_coefficients);
    const auto states = state_space_of(r);
    const Filter by_states =
        filter_from_state_space(states.at("A"), states.at("B"), states.at("C"), states.at("D"), 1000, 1);
    expect_response(f, by_states, 1e-7, name + "state space ");
    expect_figures(name + "state space", by_states);
  }
}

/// A double-double holds the sum of any two doubles; of three, c0 +- c1 + c2, it holds those without gaps.
TEST(Sections, AreExactWhereTheirSumsAre) {
  const auto deviation = [](const std::vector<double>& b, const std::vector<double>& a) {
    return filter_from_sections({{b[0], b[1], b[2], a[0], a[1], a[2]}}, 1, 0).deviation.h2;
  };
  const double full = 1 - 0x1p-40 - 0x1p-53, tiny = 0x1p-120;  // 1 + full fills 54 bits, 1 - full 14
  const std::vector<std::vector<double>> held{
      {1, 2, 1}, {1, 0.3, 0.1}, {1, 0.5, 0}, {1, tiny, 0}, {1, full, 0}};
  const std::vector<std::vector<double>> rounded{{1, full, tiny}, {1, -full, tiny}, {1, 0x1p-53, tiny}};
  for (const std::vector<double>& c : held) {
    EXPECT_EQ(deviation(c, {1, -0.5, 0.25}), 0) << c[1];
    if (c[1] < 2) {
      EXPECT_EQ(deviation({1, 0.5, 0.25}, c), 0) << c[1];
    }
  }
  for (const std::vector<double>& c : rounded)
    for (const double d : {deviation(c, {1, -0.5, 0.25}), deviation({1, 0.5, 0.25}, c)}) {
      EXPECT_GT(d, 0) << c[1];
      EXPECT_LT(d, 1e-16) << c[1];
    }
}

/// Numerators whose sum, or also whose slope, is 0 within rounding; beyond it they stay.
TEST(Sections, MoveTheirZerosToDcAsMeasured) {
  const testing::Measured measured("representation_figures.csv", 1e-8);
  const testing::Measured sizes("representation_figures.csv", 0.004);
  const double u = 0x1p-53;
  const std::vector<std::vector<double>> numerators{{1, -1, 0},
                                                    {1, -1 + u, 0},
                                                    {1, -1 + 2 * u, 0},
                                                    {1, -1 + 4 * u, 0},
                                                    {1, -2, 1},
                                                    {1, -2 + 2 * u, 1},
                                                    {1, -2 + 2 * u, 1 - u},
                                                    {1, -2 + 8 * u, 1},
                                                    {1, -2, 1 - u},
                                                    {1, -2 + 2 * u, 1 - 2 * u},
                                                    {1, -1.5, 0.5},
                                                    {1, -1.5, 0.5 + u / 2},
                                                    {0.1, 0.2, -0.3},
                                                    {0.7, -0.6, -0.1},
                                                    {1, 0, -1},
                                                    {1, 0, -1 + 2 * u},
                                                    {0.3, -0.6, 0.3},
                                                    {1e-3, -2e-3, 1e-3},
                                                    {-1, 2, -1},
                                                    {-1, 1 - u, 0},
                                                    {0, 1, -1},
                                                    {0, 1, -1 + u},
                                                    {0, 1, 0},
                                                    {0, 0, 1},
                                                    {1, -2 - 2 * u, 1},
                                                    {1, -2 - 4 * u, 1 + 2 * u},
                                                    {1, -1 - 2 * u, 0},
                                                    {0.25, -0.5, 0.25 - u / 4},
                                                    {0.25, -0.5 + u / 2, 0.25 - u / 4}};
  for (std::size_t i = 0; i < numerators.size(); ++i)
    for (const std::vector<double>& a :
         Rows{{1, -0.5, 0.25}, {1, -0.5, 0}, {2, -1.998, 0}, {1, -2 + 0x1p-19, 1 - 0x1p-19 + 0x1p-24}}) {
      std::vector<double> row = numerators[i];
      row.insert(row.end(), a.begin(), a.end());
      std::ostringstream name;
      name << "numerator " << i << " over " << a[1] << ' ' << a[2];
      const Filter f = filter_from_sections({row}, 1, 1);
      measured.expect(name.str() + ",b0", f.sections[0].b[0].hi);
      measured.expect(name.str() + ",b1", f.sections[0].b[1].hi);
      measured.expect(name.str() + ",b2", f.sections[0].b[2].hi);
      measured.expect(name.str() + ",moved", f.deviation.h2 > 0);
      const Filter g = filter_from_coefficients(numerators[i], a, 1, 1);
      measured.expect(name.str() + ",gain by coefficients", dc_gain(g));
      measured.expect(name.str() + ",low-frequency gain by coefficients", low_frequency_gain(g));
      sizes.expect(name.str() + ",deviation by coefficients",
                   g.deviation.h2 == 0 ? -999 : std::log2(g.deviation.h2));
    }
}

TEST(StateSpace, MovesItsZerosToDcAsMeasured) {
  const testing::Measured measured("representation_figures.csv", 1e-8);
  // Differences of order `zeros` before poles at 0.5, 0.25, ...; D is off by some rounding errors.
  for (int zeros = 1; zeros <= 6; ++zeros)
    for (const double off : {0.0, 0x1p-53, 0x1p-51, 0x1p-48, 0x1p-30}) {
      RootsAndGain f;
      for (int i = 0; i < zeros; ++i) {
        f.zeros.emplace_back(1);
        f.poles.emplace_back(std::ldexp(i % 2 == 0 ? 1 : -1, -1 - i));
      }
      auto states = state_space_of(ratio_of(f));
      states["D"][0][0] *= 1 + off;
      const Filter filter =
          filter_from_state_space(states["A"], states["B"], states["C"], states["D"], 1, zeros);
      std::ostringstream name;
      name << "state space of " << zeros << " zeros off by " << off;
      measured.expect(name.str() + ",gain", dc_gain(filter));
      measured.expect(name.str() + ",low-frequency gain", low_frequency_gain(filter));
    }
}

/// sum h_k q^k of a filter without poles: its taps, scaled by a power of 2 that the gain undoes.
TEST(Coefficients, WithoutPolesAreTaps) {
  for (const std::vector<double>& b :
       Rows{{3, -4}, {0.3, 0, 1e-300}, {1e200, 1}, {0}, {1}, {-0.999, 0.5}, {0, 0, 5}}) {
    const Filter f = filter_from_coefficients(b, {0.8}, 10, 2);
    ASSERT_EQ(f.taps.size(), b.size());
    double largest = 0, sum = 0;
    for (std::size_t k = 0; k < b.size(); ++k) {
      EXPECT_NEAR(static_cast<double>(f.taps[k] * f.gain), b[k] / 0.8, 1e-15 * std::abs(b[k]));
      largest = std::max(largest, std::abs(f.taps[k].hi));
      sum += std::abs(b[k] / 0.8);
    }
    if (sum > 0) {
      EXPECT_GE(largest, 1);
      EXPECT_LT(largest, 2);
    }
    EXPECT_NEAR(f.deviation.l1, 0x1p-102 * sum, 1e-9 * 0x1p-102 * sum);
    EXPECT_EQ(f.deviation.h2, f.deviation.l1);
    EXPECT_EQ(f.derivative, 2);
    EXPECT_FALSE(f.designed);
  }
}

TEST(EveryRepresentation, StatesTheDerivativeAndTheRate) {
  for (const Filter& f :
       {filter_from_coefficients({1, 2}, {1, 0.5}, 40, 3), filter_from_coefficients({1}, {1}, 40, 3),
        filter_from_sections({{1, 0, 0, 1, 0.5, 0}}, 40, 3),
        filter_from_sections({{2, 0, 0, 1, 0, 0}}, 40, 3), filter_from_zeros_and_poles({}, {{0.5}}, 2, 40, 3),
        filter_from_zeros_and_poles({}, {}, 2, 40, 3), filter_from_zeros_and_poles({}, {{0.5}}, 0, 40, 3),
        filter_from_state_space({{0.5}}, {{1}}, {{1}}, {{1}}, 40, 3),
        filter_from_state_space({{0.5}}, {{1}}, {{0}}, {{0}}, 40, 3)}) {
    EXPECT_EQ(f.sample_rate, 40);
    EXPECT_EQ(f.derivative, 3);
    EXPECT_FALSE(f.designed);
  }
}

/// I - A has a first pivot of 0.
TEST(StateSpace, WithAnUndampedStateBlocksZeroFrequency) {
  // (z - 1)/(z^2 - 1.25 z + 0.5), in the states x1' = x1 - x2/2 + u, x2' = x1/2 + x2/4.
  const Rows a{{1, -0.5}, {0.5, 0.25}}, b{{1}, {0}}, c{{1, -1.5}};
  const Filter filter = filter_from_state_space(a, b, c, {{0}}, 1, 1);
  EXPECT_EQ(dc_gain(filter), 0);
  EXPECT_NEAR(low_frequency_gain(filter), 4, 1e-14);
  EXPECT_NEAR(impulse_response(filter, 3)[2], 0.25, 1e-15);
}

/// A long chain of equal states has one root of multiplicity 2 to 6.
TEST(StateSpace, OfEqualPolesHasTheirMultiplicity) {
  for (const std::size_t n : {2, 3, 6}) {
    Rows a(n, std::vector<double>(n)), b(n, {0}), c(1, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i) {
      a[i][i] = 0.75;
      if (i > 0) a[i][i - 1] = 0.25;
    }
    b[0][0] = 0.25;
    c[0][n - 1] = 1;
    const Filter f = filter_from_state_space(a, b, c, {{0}}, 1000, 0);
    EXPECT_EQ(f.sections.size(), n);
    for (const Section& s : f.sections) EXPECT_EQ(s.a, f.sections[0].a) << n;
    EXPECT_DOUBLE_EQ(poles_max_modulus(f), 0.75);
    EXPECT_NEAR(dc_gain(f), 1, 1e-14);
  }
}

}  // namespace
}  // namespace qerr
