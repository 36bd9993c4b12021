#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "filter/design/polynomial.hpp"
#include "filter/norms/numerical_error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/random_filter.hpp"

namespace qerr {
namespace {

float rounded(const DoubleDouble& c) { return static_cast<float>(static_cast<double>(c)); }

/// A plan as code runs it, in single precision, from rest.
std::vector<double> in_float(const FilterPlan<DoubleDouble>& plan, const std::vector<double>& input) {
  std::vector<SectionState<float>> states(plan.sections.size());
  std::vector<double> results;
  for (const double value : input) {
    auto x = static_cast<float>(value);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const NormalizedSection<DoubleDouble>& s = plan.sections[i];
      const float k0 = rounded(s.k0), k1 = rounded(s.k1), b0 = rounded(s.b0), b1 = rounded(s.b1),
                  b2 = rounded(s.b2);
      x = s.second ? output<true>(b0, b1, b2, advance<true>(k0, k1, x, states[i]))
                   : output<false>(b0, b1, b2, advance<false>(k0, k1, x, states[i]));
    }
    results.push_back(static_cast<double>(x));
  }
  return results;
}

/// Checks white noise, a slow sine, and the input with the largest output; returns the largest error as a
/// part of the bound.
double largest_part(const Filter& filter, unsigned seed) {
  constexpr std::size_t count = 4000;
  const FilterPlan<DoubleDouble> plan = levelled_plan(filter);
  const RecursionError bound = recursion_error(plan, filter.sample_rate, std::ldexp(1.0, -24));
  if (!std::isfinite(bound.output)) return 0;
  std::mt19937 random(seed);
  const std::vector<double> h = impulse_response(filter, count);
  double largest = 0;
  for (int kind = 0; kind < 3; ++kind) {
    std::vector<double> input;
    for (std::size_t k = 0; k < count; ++k)
      input.push_back(kind == 0   ? std::uniform_real_distribution<>(-1, 1)(random)
                      : kind == 1 ? std::sin(0.01 * static_cast<double>(k))
                                  : std::copysign(1.0, h[count - 1 - k]));
    Cascade<DoubleDouble> exact(filter);
    const std::vector<double> found = in_float(plan, input);
    for (std::size_t k = 0; k < count; ++k)
      largest = std::max(largest, std::abs(static_cast<double>(exact.step(input[k])) - found[k]));
  }
  EXPECT_LE(largest, bound.output);
  return largest / bound.output;
}

TEST(RecursionError, IsNeverExceededInSinglePrecision) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Rows rows;
    for (const RandomFilter::Pair& s : RandomFilter(seed, 3, 1e-4).sections)
      rows.push_back({s.b[0], s.b[1], s.b[2], s.a[0], s.a[1], s.a[2]});
    largest_part(filter_from_sections(rows, 1000, 0), seed);
  }
}

TEST(RecursionError, IsOfTheOrderOfWhatIsReached) {
  for (const int order : {1, 2, 4})
    for (const double cutoff : {5.0, 50.0, 200.0})
      EXPECT_GT(largest_part(design_filter("butterworth", 1, 1000, order, cutoff), 7), 0.005);
}

TEST(RecursionError, OfALevelledPlanKeepsSignalsWithinSinglePrecision) {
  const Filter filter = design_filter("butterworth", 2, 10000, 20, 1);
  const RecursionError e = recursion_error(levelled_plan(filter), 10000, std::ldexp(1.0, -53));
  EXPECT_LT(e.largest_signal, 1e12);
  EXPECT_LT(e.output, 1e-3 * l1_norm(filter).upper);
}

}  // namespace
}  // namespace qerr
