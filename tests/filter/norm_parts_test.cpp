#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "filter/norms/autocorrelation.hpp"
#include "filter/norms/multiprecision.hpp"
#include "filter/norms/numerical_error.hpp"
#include "filter/norms/sequence.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/measured.hpp"
#include "support/random_chain.hpp"

/// The parts of the norms alone: each proven bound against the number itself, and, since a bound that is
/// wider than it was holds as well, with the width that the program found (`Measured`).
namespace qerr {
namespace {

using Wide = Binary<4096>;

Wide wide(const DoubleDouble& x) { return Wide(x.hi) + Wide(x.lo); }
template <unsigned bits>
Wide wide(const Binary<bits>& x) {
  Wide sum = 0;
  Binary<bits> remaining = x;
  for (int shift = 0; remaining != Binary<bits>(0);) {  // the last bits are below the range of double
    const double part = static_cast<double>(ldexp(remaining, shift));
    sum += ldexp(Wide(part), -shift);
    remaining -= ldexp(Binary<bits>(part), -shift);
    shift += 50;
  }
  return sum;
}
Wide wide(long double x) {
  const double high = static_cast<double>(x);
  return Wide(high) + Wide(static_cast<double>(x - high));
}

template <class T>
T random_number(testing::Dice& dice) {
  const double scale = std::exp(dice.between(-20, 20)), low = dice.between(-1, 1);
  const double high = dice.between(-1, 1) * scale;
  return T(high) + T(low * scale * 1e-20);
}

template <class T>
Ball<T> random_ball(testing::Dice& dice) {
  const T mid = random_number<T>(dice);
  const double size = std::exp(dice.between(-50, -3));
  const bool exact = dice.chance(0.3);
  return Ball<T>(mid, exact ? 0 : size * RoundingErrors<T>::magnitude(mid));
}

/// That the ball of a result holds it for the ends of its operands, and is as wide as their sum of errors.
template <class T>
void expect_ball(const Ball<T>& found, const Wide& exact, long double spread, const std::string& what) {
  const Wide distance = abs(wide(found.mid()) - exact);
  const auto rad = static_cast<long double>(found.rad());
  EXPECT_TRUE(distance <= wide(rad)) << what;
  const long double own = RoundingErrors<T>::unit * std::abs(static_cast<long double>(exact));
  EXPECT_GE(rad, spread * (1 - 1e-12L)) << what;
  EXPECT_LE(rad, (spread + own) * (1 + 1e-12L) + 2e-285L) << what;
}

template <class T>
void expect_ball_operations(std::uint64_t seed, int count) {
  testing::Dice dice(seed);
  for (int i = 0; i < count; ++i) {
    const Ball<T> x = random_ball<T>(dice), y = random_ball<T>(dice);
    const Wide a = wide(x.mid()), b = wide(y.mid());
    const auto r = static_cast<long double>(x.rad()), s = static_cast<long double>(y.rad());
    const auto size_a = static_cast<long double>(abs(a)), size_b = static_cast<long double>(abs(b));
    expect_ball(x + y, a + b, r + s, "sum");
    expect_ball(x - y, a - b, r + s, "difference");
    expect_ball(x * y, a * b, size_a * s + size_b * r + r * s, "product");
    if (s < 0.5L * size_b) expect_ball(x / y, a / b, (r + size_a / size_b * s) / (size_b - s), "quotient");
    expect_ball(abs(x), abs(a), r, "absolute value");
    expect_ball(-x, -a, r, "negative");
    if (abs(x).above_zero()) expect_ball(sqrt(abs(x)), sqrt(abs(a)), r / std::sqrt(size_a), "root");
    expect_ball(x.scaled(-7), a / Wide(128), r / 128, "scaled");
    EXPECT_TRUE(wide(static_cast<long double>(x.largest())) >= abs(a) + wide(r));
    EXPECT_TRUE(wide(static_cast<long double>(x.smallest())) <= abs(a) - wide(r));
    EXPECT_LE(static_cast<long double>(x.largest()), (size_a + r) * (1 + 1e-12L));
    EXPECT_GE(static_cast<long double>(x.smallest()), (size_a - r) - 1e-12L * (size_a + r));
    EXPECT_EQ(x.above_zero(), a > Wide(0) && size_a * (1 - 1e-14L) > r * (1 + 1e-13L));
    EXPECT_EQ(x.below_zero(), a < Wide(0) && size_a * (1 - 1e-14L) > r * (1 + 1e-13L));
    Ball<T> z = x;
    z += y;
    EXPECT_TRUE(z.mid() == (x + y).mid() && z.rad() == (x + y).rad());
    z -= y;
    EXPECT_TRUE(z.rad() > (x + y).rad());
    z *= y;
    EXPECT_TRUE(z.rad() >= y.rad() * 0);
  }
  const Ball<T> around_zero(T(0.5), 1);
  EXPECT_FALSE(around_zero.above_zero() || around_zero.below_zero());
  EXPECT_FALSE((-around_zero).above_zero() || (-around_zero).below_zero());
  EXPECT_TRUE(std::isinf((Ball<T>(1.0) / around_zero).rad()));
  EXPECT_NEAR(static_cast<double>(sqrt(around_zero).rad()), std::sqrt(1.5), 1e-12);
  EXPECT_EQ(static_cast<double>(sqrt(around_zero).mid()), 0);
}

TEST(Ball, HoldsTheResultAndIsNotWiderThanItsErrors) {
  expect_ball_operations<DoubleDouble>(61, 200);
  expect_ball_operations<Binary256>(62, 100);
  expect_ball_operations<Binary1024>(63, 10);
}

/// Bounds of sizes are rounded up, by much less than the bounds themselves.
TEST(RoundingErrors, OfSizesIsOutwards) {
  const DoubleDouble x(1, 0x1p-54);
  EXPECT_TRUE(wide(static_cast<long double>(RoundingErrors<DoubleDouble>::magnitude(x))) >= wide(x));
  EXPECT_LT(RoundingErrors<DoubleDouble>::magnitude(x), 1 + 0x1p-49);
  for (const double low : {0x1p-70, 0x1p-65, 0x1p-60}) {
    const Binary256 y = Binary256(1) + Binary256(low);
    EXPECT_TRUE(wide(RoundingErrors<Binary256>::magnitude(y)) >= wide(y));
    EXPECT_LT(RoundingErrors<Binary256>::magnitude(y), 1 + 0x1p-49L);
    EXPECT_TRUE(wide(RoundingErrors<Binary256>::magnitude(-y)) >= wide(y));
  }
  EXPECT_GT(RoundingErrors<Binary256>::magnitude(0), 0);
  EXPECT_LT(RoundingErrors<Binary256>::magnitude(0), 1e-4000L);
  const RealBall small = RealBall(1e-160) * RealBall(1e-160);  // its low word underflows
  EXPECT_GE(small.rad(), 1e-285);
  EXPECT_LE(small.rad(), 2e-285);
  EXPECT_GE(RealBall(DoubleDouble(1), 0).scaled(3).rad(), 1e-285);
  // A ball of 256 bits within double-double: its radius covers what was cut off.
  testing::Dice dice(7);
  for (int i = 0; i < 100; ++i) {
    const Binary256 third = Binary256(dice.between(1, 2)) / Binary256(3);
    const double rad = 1e-40 * dice.between(0, 1);
    const RealBall cut = rounded(FineBall(third, rad));
    EXPECT_TRUE(abs(wide(cut.mid()) - wide(third)) + Wide(rad) <= Wide(cut.rad()));
    EXPECT_LE(cut.rad(), 0x1p-106 + 1.0001 * rad);
  }
}

struct KnownFilter {
  std::string name;
  Filter filter;
};

Filter of_sections(const std::vector<std::pair<std::array<double, 3>, std::array<double, 3>>>& list) {
  Filter filter{{}, 1, 1, 0};
  for (const auto& [b, a] : list) filter.sections.push_back(section_in_w(b, a));
  return filter;
}

/// 1 - 2 m cos(angle) q + m^2 q^2; cos and square are rounded to 2^-40, so that they are the same everywhere.
std::array<double, 3> pair_at(double modulus, double cosine) {
  const auto rounded_off = [](double x) { return std::ldexp(std::round(std::ldexp(x, 40)), -40); };
  return {1, rounded_off(-2 * modulus * cosine), rounded_off(modulus * modulus)};
}

/// Real, complex, repeated and nearly repeated poles, fast and slow ones, at z = -1 and at z = 0.
std::vector<KnownFilter> known_filters() {
  return {
      {"one pole", of_sections({{{1, 0, 0}, {1, -0.75, 0}}})},
      {"slow pole", of_sections({{{1, 0.5, 0}, {1, -1 + 0x1p-20, 0}}})},
      {"poles", of_sections({{{1, -1, 0}, {1, -0.5, 0}}, {{1, 0, 0}, {1, 0.875, 0}}})},
      {"real poles", of_sections({{{1, -1, 0.5}, {1, -1.25, 0.375}}, {{1, 2, 1}, {1, -1.8125, 0.8203125}}})},
      {"resonance", of_sections({{{1, 0, 0}, pair_at(0.998, 0.955)}})},
      {"slow resonance", of_sections({{{1, -1, 0.5}, pair_at(1 - 0x1p-18, 0.25)}})},
      {"resonances", of_sections({{{1, -1, 0}, pair_at(0.99, 0.9)}, {{0.5, 1, 1}, pair_at(0.97, -0.4)}})},
      {"repeated pole",
       of_sections(
           {{{1, 0, 0}, {1, -0.96875, 0}}, {{1, 1, 0}, {1, -0.96875, 0}}, {{1, -0.5, 0}, {1, -0.96875, 0}}})},
      {"repeated resonance",
       of_sections({{{1, 0, 0}, pair_at(0.98, 0.7)}, {{1, -1, 0}, pair_at(0.98, 0.7)}})},
      {"close poles", of_sections({{{1, 0, 0}, {1, -0.96875, 0}}, {{1, 0, 0}, {1, -0.96875 - 0x1p-14, 0}}})},
      {"pole at 0", of_sections({{{1, -1, 0}, {1, 0, 0}}, {{1, 0, 1}, {1, -0.984375, 0}}})},
      {"low-pass", design_filter("butterworth", 1, 1000, 5, 2)},
      {"differences", design_filter("first_order", 2, 1000, 4, 3)},
      {"alternating", of_sections({{{1, 0, 0}, {1, 1 - 0x1p-10, 0}}, {{1, 0, 0}, {1, -1 + 0x1p-9, 0}}})}};
}

double logarithm(double x) { return x > 0 ? std::log2(x) : -2000; }

/// Figures of the filters: values with eight digits, and errors, which are bounded in powers of two.
class Figures {
 public:
  explicit Figures(std::string name) : name_(std::move(name)) {}
  void value(const std::string& what, double x) const { values_.expect(name_ + ',' + what, x); }
  /// Of rounding, or a bound in doubles: may differ by some percent.
  void error(const std::string& what, double x) const { errors_.expect(name_ + ',' + what, logarithm(x)); }
  /// A number of steps, which depends on comparisons that rounding can turn.
  void count(const std::string& what, double x) const { counts_.expect(name_ + ',' + what, x); }

 private:
  std::string name_;
  testing::Measured values_{"norm_parts.csv", 1e-8}, errors_{"norm_parts.csv", 1e-3},
      counts_{"norm_parts.csv", 0.01};
};

TEST(NormParts, PolesAndTheirModesAreThoseMeasured) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    const Poles all = poles(f.filter);
    figures.value("poles", static_cast<double>(all.list.size()));
    figures.error("change by merging", all.change);
    const Modes modes = partial_fractions(f.filter, all.list);
    figures.value("modes from", static_cast<double>(modes.from));
    for (std::size_t i = 0; i < modes.modes.size(); ++i) {
      const Mode& m = modes.modes[i];
      const std::string mode = "mode " + std::to_string(i) + ' ';
      figures.value(mode + "pair", m.pair);
      figures.value(mode + "coefficients", static_cast<double>(m.c.size()));
      figures.value(mode + "1 - modulus", one_minus_modulus(m.one_minus_z));
      figures.value(mode + "angle", 1 + angle(m.z));
      figures.error(mode + "error of z", static_cast<double>(m.z.re.rad()));
      for (std::size_t k = 0; k < m.c.size(); ++k) {
        const std::string c = mode + "c" + std::to_string(k) + ' ';
        figures.value(c + "size", largest(m.c[k]));
        figures.error(c + "error", m.c[k].re.rad());
        figures.error(c + "error of the imaginary part", m.c[k].im.rad());
      }
      figures.value(mode + "tail", tail(m, 200));
    }
  }
}

/// Poles closer than rounding are one; those of a section of equal roots, too.
TEST(NormParts, MergePolesWithinRounding) {
  const auto multiplicities = [](const Filter& f) {
    std::string text;
    for (const Pole& p : poles(f).list) text += std::to_string(p.multiplicity) + (p.real() ? "r" : "c");
    return text;
  };
  EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, -1, 0.25}}})), "2r");
  EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, -1, 0.25 - 0x1p-40}}})), "1r1r");
  EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, -1, 0.25 + 0x1p-40}}})), "1c");
  const double p = 0.9375;
  for (const auto& [off, text] : {std::pair{0x1p-53, "2r"}, std::pair{0x1p-50, "1r1r"}})
    EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, -p, 0}}, {{1, 0, 0}, {1, -p - off, 0}}})), text);
  EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, -1, 0.5}}, {{1, 0, 0}, {1, -1, 0.5}}})), "2c");
  EXPECT_EQ(multiplicities(of_sections({{{1, 0, 0}, {1, 0, 0}}})), "1r");
  EXPECT_EQ(multiplicities(difference_filter(1, 3)), "3r");
}

/// What merging changes, of poles as far apart as just merge.
TEST(NormParts, MergedPolesChangeTheFilterAsMeasured) {
  const double near = 1 + 3e-15;
  for (const double slope : {1.5, 30.0, 1e6})
    for (const std::size_t count : {1, 3, 20}) {
      std::ostringstream slopes;
      slopes << slope;
      const Figures figures(std::to_string(count) + " merged of slope " + slopes.str());
      const auto changed = [&](const std::string& what, const Section& first, const Section& other) {
        Filter filter{{first}, 1, 1, 0};
        filter.sections.insert(filter.sections.end(), count, other);
        const Poles all = poles(filter);
        EXPECT_EQ(all.list.back().multiplicity % static_cast<int>(count + 1), 0) << what;
        figures.error(what, all.change);
        return all.change;
      };
      // ||1/(1 + slope w)||_1 of a relative shift of the slope by 3e-15: at least as much, and a few times
      // it.
      const double real = changed("real", {{1, 0, 0}, {1, slope, 0}}, {{1, 0, 0}, {1, near * slope, 0}});
      EXPECT_GT(real, 2e-15 * static_cast<double>(count));
      EXPECT_LT(real, 1e-14 * static_cast<double>(count));
      const double square = slope * slope;
      changed("of a pair", {{1, 0, 0}, {1, 1.8 * slope, square}},
              {{1, 0, 0}, {1, 1.8 * near * slope, near * near * square}});
      changed("of a section", {{1, 0, 0}, {1, 3 * slope, 2 * square}},
              {{1, 0, 0}, {1, 3 * near * slope, 2 * near * near * square}});
    }
}

TEST(NormParts, PowersOfModesAreEnclosed) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    const Modes modes = partial_fractions(f.filter, poles(f.filter).list);
    const Powers powers(modes.modes);
    std::vector<std::complex<double>> quick;
    std::vector<double> moduli;
    for (const std::int64_t k : {0, 1, 15, 16, 255, 4095, 70000}) {
      const std::vector<ComplexBall> proven = powers.proven(k);
      powers.quick(k, quick);
      powers.moduli(k, moduli);
      for (std::size_t i = 0; i < proven.size(); ++i) {
        const FineComplex exact = power(modes.modes[i].z, k);
        const double re = static_cast<double>(exact.re.mid()), im = static_cast<double>(exact.im.mid());
        const double modulus = std::hypot(re, im);
        const Wide off = abs(wide(proven[i].re.mid()) - wide(exact.re.mid()));
        EXPECT_TRUE(off <= wide(static_cast<long double>(proven[i].re.rad()) + exact.re.rad()))
            << f.name << k;
        EXPECT_LE(std::abs(quick[i] - std::complex<double>(re, im)), 1e-14 * modulus + 1e-290) << f.name << k;
        EXPECT_GE(moduli[i], modulus * (1 - 1e-12)) << f.name << k;
        EXPECT_LE(moduli[i], modulus * (1 + 1e-9) + 1e-290) << f.name << k;
        EXPECT_EQ(moduli[i], powers.modulus(i, k));
        if (modulus > 1e-30)
          figures.error("error of power " + std::to_string(k) + " of mode " + std::to_string(i),
                        proven[i].re.rad() / modulus);
      }
    }
  }
}

/// h_k, its differences and sums, as modes and from the filter itself.
TEST(NormParts, SequencesAreTheImpulseResponse) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    const Modes modes = partial_fractions(f.filter, poles(f.filter).list);
    const Powers powers(modes.modes);
    const Sequence x(modes.modes, powers), sum = x.transient_of_sum(), difference = x.difference();
    const Sequence twice = x.plus(2, difference);
    const std::vector<double> h = impulse_response(f.filter, 400);
    double scale = 0;
    for (const double value : h) scale = std::max(scale, std::abs(value));
    std::vector<std::complex<double>> quick;
    const auto first = static_cast<std::int64_t>(modes.from);
    EXPECT_TRUE(x.accurate()) << f.name;
    figures.value("mean multiplicity", x.mean_multiplicity());
    for (const std::int64_t k : {first + 1, first + 2, first + 17, std::int64_t{399}}) {
      const auto at = static_cast<std::size_t>(k);
      const std::string sample = "sample " + std::to_string(k) + ' ';
      EXPECT_NEAR(static_cast<double>(x.at(k).mid()), h[at], 1e-14 * scale) << f.name << k;
      powers.quick(k, quick);
      EXPECT_NEAR(x.quick_at(k, quick), h[at], 1e-12 * x.bound(k, k)) << f.name << k;
      EXPECT_NEAR(static_cast<double>(difference.at(k).mid()), h[at] - h[at - 1], 1e-13 * scale) << f.name;
      EXPECT_NEAR(static_cast<double>((sum.at(k) - sum.at(k - 1)).mid()), h[at], 1e-13 * scale) << f.name;
      EXPECT_NEAR(static_cast<double>(twice.at(k).mid()), h[at] + 2 * (h[at] - h[at - 1]), 1e-13 * scale);
      figures.error(sample + "error", x.at(k).rad());
      figures.value(sample + "bound", x.bound(k, k + 100));
      figures.value(sample + "bound of the difference", difference.bound(k, k));
      figures.value(sample + "tail", x.tail(k));
      figures.value(sample + "sum", 3 * sum.bound(k, k) + static_cast<double>(sum.at(k).mid()));
      const Differences differences(x);
      const double variation = differences.variation(k - 1, k + 9, k + 2, powers.proven(k + 2));
      figures.value(sample + "variation", variation);
      for (std::int64_t i = k - 1; i < k + 9; ++i)
        EXPECT_LE(std::abs(static_cast<double>((x.at(i) - x.at(k + 2)).mid())), variation) << f.name << k;
      const std::vector<ComplexBall> at_k = powers.proven(k);
      EXPECT_EQ(static_cast<double>(differences.first().at(k, at_k).mid()),
                static_cast<double>(difference.at(k).mid()));
      EXPECT_EQ(static_cast<double>(differences.second().at(k, at_k).mid()),
                static_cast<double>(difference.difference().at(k).mid()));
    }
  }
}

TEST(NormParts, EveryNthSampleIsASequence) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    const Modes modes = partial_fractions(f.filter, poles(f.filter).list);
    const Powers powers(modes.modes);
    const Sequence x(modes.modes, powers);
    for (const std::int64_t step : {2, 3, 8})
      for (const std::int64_t offset : {std::int64_t{0}, step - 1}) {
        std::vector<Mode> part;
        for (const Mode& m : modes.modes) part.push_back(decimated(m, step, offset));
        const Powers of_part(part);
        const Sequence y(part, of_part);
        for (const std::int64_t k : {1, 2, 30}) {
          const RealBall left = y.at(k), right = x.at(step * k + offset);
          EXPECT_LE(std::abs(static_cast<double>((left - right).mid())), left.rad() + right.rad())
              << f.name << step << offset << k;
        }
        for (const Mode& m : part) EXPECT_GE(static_cast<double>(m.z.im.mid()), 0);
        figures.error("error of every " + std::to_string(step) + " from " + std::to_string(offset),
                      y.at(30).rad());
      }
    figures.value("decimation",
                  static_cast<double>(decimation(modes.modes, static_cast<std::int64_t>(modes.from), 1)));
  }
}

TEST(NormParts, DirectSumsAreThoseMeasured) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    Filter unit = f.filter;
    unit.gain = 1;
    const double gap = std::min(1.0, 0.5 * (1 / std::max(poles_max_modulus(unit), 1e-9) - 1));
    for (const double lift : {gap, gap / 64}) {
      const DirectSum direct(unit, lift);
      const std::string start = lift == gap ? "direct sum " : "direct sum of small lift ";
      for (const int count : {1, 2, 40, 300}) {
        const PartialSum p = direct.sum(count);
        double exact = 0;
        for (const double h : impulse_response(unit, static_cast<std::size_t>(count))) exact += std::abs(h);
        EXPECT_NEAR(p.sum, exact, 1e-12 * exact) << f.name;
        // Without the rounding of the result to double, which hides the others.
        const double before = p.error - 0x1p-53 * p.sum;
        EXPECT_GT(before, 0) << f.name;
        figures.error(start + "error of " + std::to_string(count), before);
      }
      figures.value(start + "tail 0", direct.tail(0));
      figures.value(start + "tail 500", direct.tail(500));
      figures.value(start + "lifted norm", lifted_norm(unit, lift));
    }
  }
}

/// sum |h_k| over a range by each of the methods, which agree within their errors.
TEST(NormParts, SumsOfModesAreThoseMeasured) {
  for (const KnownFilter& f : known_filters()) {
    const Figures figures(f.name);
    Filter unit = f.filter;
    unit.gain = 1;
    const Modes modes = partial_fractions(unit, poles(unit).list);
    const Powers powers(modes.modes);
    const Sequence x(modes.modes, powers);
    const auto first = static_cast<std::int64_t>(modes.from);
    const bool simple =
        std::all_of(modes.modes.begin(), modes.modes.end(), [](const Mode& m) { return m.c.size() == 1; });
    for (const std::int64_t count : {5, 256, 700, 3000}) {
      const std::string range = "over " + std::to_string(count) + ' ';
      double exact = 0;
      for (std::int64_t k = first; k < first + count; ++k)
        exact += std::abs(static_cast<double>(x.at(k).mid()));
      const RunsSum runs = sum_of_runs(x, powers, exact, first, first + count, 100000);
      EXPECT_NEAR(static_cast<double>(runs.sum.mid()), exact, 1e-13 * exact + runs.error) << f.name << count;
      EXPECT_LT(runs.error + runs.sum.rad(), 1e-12 * exact) << f.name << count;
      EXPECT_EQ(runs.next, first + count);
      figures.error(range + "error of runs", runs.sum.rad());
      figures.error(range + "negligible values of runs", runs.error);
      figures.count(range + "visits", static_cast<double>(100000 - runs.visits));
      const std::int64_t few = (100000 - runs.visits) / 2;
      const RunsSum stopped = sum_of_runs(x, powers, exact, first, first + count, few);
      EXPECT_EQ(stopped.visits, 0) << f.name << count;
      figures.count(range + "stopped at", static_cast<double>(stopped.next));
      double part = 0;
      for (std::int64_t k = first; k < stopped.next; ++k)
        part += std::abs(static_cast<double>(x.at(k).mid()));
      EXPECT_NEAR(static_cast<double>(stopped.sum.mid()), part, 1e-13 * exact + stopped.error) << f.name;
      if (simple) {
        const SampledSum s = sampled_sum(modes.modes, powers, first, first + count);
        EXPECT_NEAR(s.sum, exact, s.error) << f.name << count;
        figures.value(range + "error of samples", s.error);
      }
      if (simple && modes.modes.size() == 1 && modes.modes[0].pair) {
        const RealBall r = resonance_sum(modes.modes[0], first, first + count);
        EXPECT_NEAR(static_cast<double>(r.mid()), exact, 1e-13 * exact) << f.name << count;
        figures.error(range + "error of the resonance", r.rad());
      }
    }
    const double scale = l1_norm(unit).lower;
    for (const std::int64_t work : {2000000, 3000, 100}) {
      const TailSum t = tail_sum(modes.modes, first, scale, work);
      const std::string start = "tail sum with work " + std::to_string(work) + ' ';
      figures.value(start + "sum", static_cast<double>(t.sum.mid()) + scale);
      figures.error(start + "radius", t.sum.rad());
      figures.error(start + "error", t.error);
      figures.error(start + "beyond", t.beyond);
    }
  }
}

/// Sums of a resonance over any range, from any start: sum |2 Re(c z^k)|.
TEST(ResonanceSum, IsTheSumOfItsTermsWithinItsError) {
  testing::Dice dice(88);
  for (int i = 0; i < 40; ++i) {
    const double modulus = 1 - std::exp(dice.between(-14, -1)), cosine = dice.between(-1, 1);
    const Filter f = of_sections({{{1, i % 2 == 0 ? 0.5 : -1, 0}, pair_at(modulus, cosine)}});
    const Modes modes = partial_fractions(f, poles(f).list);
    if (!modes.modes[0].pair) continue;
    const Powers powers(modes.modes);
    const Sequence x(modes.modes, powers);
    const auto from = static_cast<std::int64_t>(dice.below(50));
    const auto end = from + 1 + static_cast<std::int64_t>(dice.below(i < 20 ? 30 : 2000));
    RealBall exact;
    for (std::int64_t k = from; k < end; ++k) exact += abs(x.at(k));
    const RealBall sum = resonance_sum(modes.modes[0], from, end);
    EXPECT_TRUE(abs(wide(sum.mid()) - wide(exact.mid())) <=
                wide(static_cast<long double>(sum.rad()) + exact.rad()))
        << i;
    testing::Measured("norm_parts.csv", 1e-3)
        .expect("resonance " + std::to_string(i) + ",error", std::log2(sum.rad()));
    EXPECT_LT(sum.rad(), 1e-25 * static_cast<double>(exact.mid())) << i;
  }
}

/// ||b/a - H|| of coefficients that are not quite those of H.
TEST(Deviation, IsABoundOfTheDifferenceAsMeasured) {
  const testing::Measured measured("norm_parts.csv", 1e-6), errors("norm_parts.csv", 1e-3);
  for (const double a1 : {-0.5, -1.9, 1.5})
    for (const double off : {0.0, 1e-3, 1e-9, -1e-14}) {
      const std::vector<double> b{1, -0.5, 0.25}, a{1, a1, 0.9025};
      const Filter h = of_sections({{{1, -0.5, 0.25 + off}, {1, a1, 0.9025}}});
      const auto d = deviation_of(h, b, a, 0.95);
      ASSERT_TRUE(d);
      // The difference is off q^2/a.
      const Filter unit = of_sections({{{0, 0, 1}, {1, a1, 0.9025}}});
      const double size = std::abs((0.25 + off) - 0.25);
      EXPECT_GE(d->h2, size * h2_norm(unit) * (1 - 1e-12));
      EXPECT_LE(d->h2, size * h2_norm(unit) * (1 + 1e-12) + 1e-200);
      EXPECT_GE(d->l1, size * l1_norm(unit).lower);
      std::ostringstream name;
      name << "deviation " << a1 << ' ' << off;
      if (off != 0) measured.expect(name.str() + ",l1", d->l1);
      if (off == 0) errors.expect(name.str() + ",of rounding", std::log2(d->h2));
      if (off == 0) errors.expect(name.str() + ",l1 of rounding", std::log2(d->l1));
      const auto slower = deviation_of(h, b, a, 0.999);  // a wrong modulus: wider, or nothing to say
      ASSERT_TRUE(slower);
      EXPECT_GE(slower->l1, size * l1_norm(unit).lower);
    }
  const Filter h = of_sections({{{1, 0, 0}, {1, -0.5, 0}}});
  EXPECT_FALSE(deviation_of(h, std::vector<double>{1}, std::vector<double>{1, -1}, 0.5));
  EXPECT_FALSE(deviation_of(h, std::vector<double>{1}, std::vector<double>{1, -1.5}, 0.5));
  EXPECT_TRUE(std::isinf(deviation_of(h, std::vector<double>{1}, std::vector<double>{1, -0.999}, 0.5)->l1));
}

TEST(LiftedNorm, IsTheNormOfTheGrownResponse) {
  for (const KnownFilter& f : known_filters()) {
    const double gap = 1 / std::max(poles_max_modulus(f.filter), 0.5) - 1;
    for (const double lift : {0.2 * gap, 0.6 * gap}) {
      double squares = 0, grown = 1;
      if (gap < 1e-3) continue;
      for (const double h :
           impulse_response(f.filter, 200000 > 40 / gap ? static_cast<std::size_t>(40 / gap) + 60 : 200000)) {
        squares += h * grown * h * grown;
        grown *= 1 + lift;
      }
      EXPECT_GE(lifted_norm(f.filter, lift), std::sqrt(squares) * (1 - 1e-12)) << f.name;
      EXPECT_LE(lifted_norm(f.filter, lift), std::sqrt(squares) * 1.1) << f.name;
    }
    EXPECT_TRUE(std::isinf(lifted_norm(f.filter, 1.1 * gap + 1))) << f.name;
  }
}

/// r_n = sum h_k h_(k+n), and what is cut off.
TEST(AutocorrelationParts, AreThoseOfTheResponse) {
  std::vector<KnownFilter> list = known_filters();
  list.push_back({"taps", {{}, 0.5, 1, 0, {0.3, 0, -1, 0.25}}});
  list.push_back({"moving average", {{}, 1, 1, 0, std::vector<DoubleDouble>(900, 1.0 / 900)}});
  for (const KnownFilter& f : list) {
    if (poles_max_modulus(f.filter) > 0.9999) continue;
    const Figures figures(f.name);
    const Autocorrelation a = autocorrelation(f.filter);
    figures.count("lags", static_cast<double>(a.r.size()));
    figures.error("tail of lags", a.tail);
    EXPECT_EQ(a.dc_gain, dc_gain(f.filter));
    const std::vector<double> h = impulse_response(f.filter, f.filter.taps.empty() ? 24000 : 900);
    double squares = 0;
    for (const double x : h) squares += x * x;
    EXPECT_NEAR(a.r[0], squares, 1e-11 * squares) << f.name;
    for (const std::size_t n : {0, 1, 2, 7, 100, 899}) {
      if (n >= a.r.size()) continue;
      double exact = 0;
      for (std::size_t k = 0; k + n < h.size(); ++k) exact += h[k] * h[k + n];
      EXPECT_NEAR(a.r[n], exact, 1e-11 * squares) << f.name << n;
    }
    double both = a.r[0];
    for (std::size_t n = 1; n < a.r.size(); ++n) both += 2 * a.r[n];
    EXPECT_NEAR(both, a.dc_gain * a.dc_gain, 2 * a.tail + 1e-10 * (squares + a.dc_gain * a.dc_gain))
        << f.name;
    EXPECT_EQ(autocorrelation_within(f.filter)->r.size(), a.r.size());
    EXPECT_FALSE(autocorrelation_within(f.filter, 3));
  }
}

TEST(Transients, OfEveryNthSampleAreThoseOfAll) {
  std::vector<KnownFilter> list = known_filters();
  list.push_back({"taps", {{}, 0.5, 1, 0, {0.3, 0, -1, 0.25}}});
  for (const KnownFilter& f : list) {
    const std::vector<double> h = impulse_response(f.filter, 60), sigma = noise_transient(f.filter, 60);
    const double scale = sigma.back();
    for (const std::size_t every : {2, 7}) {
      const std::vector<double> some = impulse_response(f.filter, 8, every),
                                part = noise_transient(f.filter, 8, every);
      for (std::size_t k = 0; k < 8; ++k) {
        EXPECT_NEAR(some[k], h[k * every], 1e-12 * scale) << f.name;
        EXPECT_NEAR(part[k], sigma[k * every], 1e-12 * scale) << f.name;
      }
    }
    double squares = 0;
    for (std::size_t k = 0; k < 60; ++k) {
      squares += h[k] * h[k];
      EXPECT_NEAR(sigma[k], std::sqrt(squares), 1e-13 * scale) << f.name;
    }
  }
}

}  // namespace
}  // namespace qerr
