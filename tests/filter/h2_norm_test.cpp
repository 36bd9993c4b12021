#include <gtest/gtest.h>

#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/random_filter.hpp"
#include "support/reference_norm.hpp"

namespace qerr {
namespace {

using reference::Exact;
using reference::Exacts;

/// The exact polynomials of a random filter, numerator and denominator.
std::pair<Exacts, Exacts> multiplied_out(const RandomFilter& r) {
  Exacts b{1}, a{1};
  for (const auto& s : r.sections) {
    b = reference::product(b, Exacts(s.b.begin(), s.b.end()));
    a = reference::product(a, Exacts(s.a.begin(), s.a.end()));
  }
  for (int i = 0; i < r.differences; ++i) b = reference::product(b, {1, -1});
  return {b, a};
}

struct Tally {
  int met = 0;
  double worst_used = 0;      // share of the stated error that was needed
  double worst_relative = 0;  // of the stated error

  void check(const Estimate& n, const Exact& squared, const std::string& what) {
    ASSERT_GT(squared, 0) << what;
    const Exact exact = sqrt(squared);
    const Exact error = abs(Exact(n.value) - exact);
    EXPECT_LE(error, Exact(n.error)) << what << ": " << n.value << ", off by " << static_cast<double>(error);
    worst_used = std::max(worst_used, static_cast<double>(error) / n.error);
    worst_relative = std::max(worst_relative, n.error / n.value);
    ++met;
  }
};

TEST(H2Norm, OfRandomSectionsIsWithinItsErrorOfTheExactOne) {
  Tally tally;
  for (unsigned seed = 0; seed < 150; ++seed) {
    const RandomFilter random(seed);
    Filter filter = difference_filter(0.5, random.differences);
    for (const auto& s : random.sections) filter.sections.push_back(section_in_w(s.b, s.a));
    const auto [b, a] = multiplied_out(random);
    // At a sample rate of 0.5 Hz the differences have the gain 2^-d.
    tally.check(h2_estimate(filter), reference::squared_norm(b, a) * ldexp(Exact(1), -2 * random.differences),
                "seed " + std::to_string(seed));
  }
  EXPECT_EQ(tally.met, 150);
  EXPECT_LT(tally.worst_relative, 3e-16);
  EXPECT_GT(tally.worst_used, 0.9) << "the bound would be far from tight";
}

TEST(H2Norm, OfAPoleOneTrillionthFromTheUnitCircleIsItsClosedForm) {
  const double a = 1 - 1e-12;
  const Estimate h2 = h2_estimate(filter_from_coefficients({1}, {1, -a}, 1, 0));
  const Exact exact = 1 / sqrt(1 - Exact(a) * a);
  EXPECT_LE(abs(h2.value - exact), h2.error);
  EXPECT_LT(h2.error, 2e-16 * h2.value);
}

TEST(H2Norm, OfRandomExpandedCoefficientsIsWithinItsErrorOfTheExactOne) {
  Tally tally;
  int needlessly = 0;
  for (unsigned seed = 0; seed < 35; ++seed) {
    const auto [exact_b, exact_a] = multiplied_out(RandomFilter(seed));
    std::vector<double> b, a;
    for (const Exact& c : exact_b) b.push_back(static_cast<double>(c));
    for (const Exact& c : exact_a) a.push_back(static_cast<double>(c));
    const Exact squared = reference::squared_norm(Exacts(b.begin(), b.end()), Exacts(a.begin(), a.end()));
    const std::string what = "seed " + std::to_string(seed);
    try {
      const Filter filter = filter_from_coefficients(b, a, 1, 0);
      tally.check(h2_estimate(filter), squared, what);
    } catch (const Error& e) {
      EXPECT_EQ(e.faults().at(0).key, "denominator") << what << e.what();
      needlessly += squared > 0;  // closer to the unit circle than the rounding of the coefficients resolves
    }
  }
  EXPECT_GT(tally.met, 7) << "many expanded filters are unstable by rounding, but not most";
  EXPECT_LT(needlessly, 3);
  EXPECT_LT(tally.worst_relative, 2e-13);
}

}  // namespace
}  // namespace qerr
