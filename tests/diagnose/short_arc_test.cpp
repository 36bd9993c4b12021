#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// Periodic errors of a direct drive that moves over a part of their period only.
namespace qerr {
namespace {

Machine moved_over(double arc, unsigned seed) {
  Machine m(seed);
  const double wide = m.path.maxCoeff() - m.path.minCoeff();
  for (auto& sine : m.sines) sine.first *= arc / wide;
  m.path = m.along(m.time);
  return m;
}

Diagnosis diagnosed(Machine& m, int order, double counts) {
  const double size = counts * m.resolution, phase = m.between(0, 2 * std::numbers::pi);
  return diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.path + size * (order * m.path + phase).sin())));
}

bool has_one_cause(const Diagnosis& d, const char* type, int order) {
  return d.unexplained.empty() && d.causes.size() == 1 && d.causes[0].effect.type == type &&
         d.causes[0].effect.number("order") == order;
}

TEST(ShortArc, OfThreeTenthsOfAPeriodTellsAnOrderAboveOne) {
  constexpr int records = 6;
  int right = 0;
  for (unsigned seed = 1; seed <= records; ++seed) {
    const int order = 2 + static_cast<int>(seed) % 3;
    Machine m(seed);
    m = moved_over(m.between(0.3, 0.9) * 2 * std::numbers::pi / order, seed);
    right += has_one_cause(diagnosed(m, order, m.between(2, 40)), "transmission_error", order);
  }
  EXPECT_GE(right, records - 1);
}

TEST(ShortArc, OfLessThanAQuarterTurnIsOfOneOrderOrAHigherOne) {
  constexpr int records = 6;
  int right = 0;
  for (unsigned seed = 101; seed <= 100 + records; ++seed) {
    Machine m(seed);
    m = moved_over(m.between(0.14, 0.24) * 2 * std::numbers::pi, seed);
    const Diagnosis d = diagnosed(m, 1, m.between(5, 40));
    right += has_one_cause(d, "eccentricity", 1) &&
             std::any_of(d.alternatives.begin(), d.alternatives.end(),
                         [](const AlternativeCause& a) { return a.effect == "transmission_error"; });
  }
  EXPECT_GE(right, records - 1);
}

bool has_alternative(const Diagnosis& d, const char* effect) {
  return std::any_of(d.alternatives.begin(), d.alternatives.end(),
                     [&](const AlternativeCause& a) { return a.effect == effect; });
}

bool is_named(const Diagnosis& d, const char* effect) {
  return std::any_of(d.causes.begin(), d.causes.end(),
                     [&](const Cause& c) { return c.effect.type == effect; });
}

/// A line through any point, with a slope, is a small part of a sine.
TEST(ShortArc, OfAFewHundredthsOfATurnMayBeAnOffsetWithAScale) {
  constexpr int records = 4;
  int honest = 0;
  for (unsigned seed = 201; seed <= 200 + records; ++seed) {
    Machine m(seed);
    m = moved_over(m.between(0.04, 0.09) * 2 * std::numbers::pi, seed);
    const Diagnosis d = diagnosed(m, 1, m.between(15, 50));
    honest += d.unexplained.empty() && (is_named(d, "eccentricity") || has_alternative(d, "eccentricity"));
  }
  EXPECT_GE(honest, records - 1);
}

/// That a sine vanishes where the zero is would be chance.
TEST(ShortArc, LeavesAScaleBareWhoseZeroIsRight) {
  constexpr int records = 4;
  int bare = 0;
  for (unsigned seed = 301; seed <= 300 + records; ++seed) {
    Machine m(seed);
    m.centre += m.centre < 0 ? -0.5 : 0.5;
    m = moved_over(m.between(0.04, 0.2) * 2 * std::numbers::pi, seed);
    const double scale = m.between(10, 40) * m.resolution / m.path.abs().maxCoeff();
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted((1 + scale) * m.path)));
    bare += d.causes.size() == 1 && is_named(d, "scale") && d.unexplained.empty() &&
            !has_alternative(d, "eccentricity") && !has_alternative(d, "transmission_error");
  }
  EXPECT_GE(bare, records - 1);
}

}  // namespace
}  // namespace qerr
