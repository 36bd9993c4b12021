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
  constexpr int records = 12;
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

}  // namespace
}  // namespace qerr
