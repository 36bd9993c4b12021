#include <gtest/gtest.h>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

/// Tens of counts of delay: the square of the delay matters, and must not be taken for an error of the scale.
TEST(Latency, OfManyCountsIsTheOnlyCause) {
  for (unsigned seed = 1; seed <= 16; ++seed) {
    Machine m(400 + seed);
    const double delay = (1 + 0.25 * seed) / m.rate;
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.along(m.time - delay))));
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "latency") << seed;
    EXPECT_TRUE(d.alternatives.empty()) << seed;
    EXPECT_NEAR(d.causes[0].effect.number("delay"), delay, 1e-3 * delay) << seed;
    EXPECT_LT(d.gain.counts_after, 0.45) << seed;
  }
}

}  // namespace
}  // namespace qerr
