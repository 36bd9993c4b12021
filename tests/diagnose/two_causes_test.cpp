#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

/// Every parameter of a diagnosis' causes, with its interval.
std::map<std::string, FoundParameter> found_by(const Diagnosis& d) {
  std::map<std::string, FoundParameter> found;
  for (const Cause& c : d.causes)
    for (const FoundParameter& p : c.parameters) found[c.effect.type + ' ' + p.name] = p;
  return found;
}

Machine swinging(unsigned seed) {
  Machine m(seed);
  m.rate = 200, m.rows = 2400, m.resolution = 5e-5, m.noise = 0.02 * m.resolution;
  m.sines = {{1.1, {2 * std::numbers::pi * 0.175, 0}}, {0.97, {2 * std::numbers::pi * 0.499, 0}}};
  m.centre = 0;
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = m.along(m.time);
  return m;
}

/// A wrong ratio multiplies a reading that is late.
TEST(TwoCauses, IntervalsBesideAScaleHoldTheDelay) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m = swinging(seed);
    const double scale = 1.5e-3, delay = 0.8e-3;
    const Diagnosis d =
        diagnose(model_of(m), {}, {}, log_of(m, m.counted((1 + scale) * m.along(m.time - delay))));
    const auto found = found_by(d);
    ASSERT_TRUE(found.contains("latency delay") && found.contains("scale scale")) << seed;
    EXPECT_LE(found.at("latency delay").lower, delay) << seed;
    EXPECT_GE(found.at("latency delay").upper, delay) << seed;
  }
}

/// A time constant is where the readings have it, to its interval.
TEST(TwoCauses, IntervalsOfADriftHoldItsTimeConstant) {
  int inside = 0;
  constexpr int records = 8;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Machine m = swinging(seed);
    const double constant = m.between(2, 5);
    const Column read = m.path + 2e-3 * (1 - (-m.time / constant).exp());
    const auto found = found_by(diagnose(model_of(m), {}, {}, log_of(m, m.counted(read))));
    ASSERT_TRUE(found.contains("drift time_constant")) << seed;
    const FoundParameter p = found.at("drift time_constant");
    inside += p.lower <= constant && constant <= p.upper;
  }
  EXPECT_GE(inside, records - 1);
}

}  // namespace
}  // namespace qerr
