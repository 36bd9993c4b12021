#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// Two masses with play between them: a drive, whose encoder is read, and a joint that only its own dry
/// friction slows while no flank touches it. The flanks are springs with dampers, integrated in steps of 1/64
/// row.
namespace qerr {
namespace {

struct TwoMasses {
  double gap, friction;  ///< of the joint, per inertia [rad/s^2]

  /// The joint's position at each row of the drive's path.
  template <class Drive>
  Column joint(const Column& time, const Drive& drive) const {
    constexpr int steps = 64;
    const double interval = time[1] - time[0], h = interval / steps;
    const double stiffness = std::pow(0.1 / h, 2), damping = 2 * std::sqrt(stiffness);
    Column y(time.size());
    double speed = (drive(time[0] + h) - drive(time[0])) / h;
    double at = drive(time[0]) - std::copysign(0.5 * gap, speed);
    for (Eigen::Index k = 0; k < time.size(); ++k) {
      y[k] = at;
      for (int i = 0; i < steps; ++i) {
        const double t = time[k] + i * h, lead = drive(t) - at;
        double force = 0;
        if (std::abs(lead) > 0.5 * gap)
          force = stiffness * (lead - std::copysign(0.5 * gap, lead)) +
                  damping * ((drive(t + h) - drive(t)) / h - speed);
        speed += h * force;
        const double slower = std::max(0.0, std::abs(speed) - h * friction);
        speed = std::copysign(slower, speed);
        at += h * speed;
      }
    }
    return y;
  }
};

/// The flanks' springs and the rounding of the readings leave 1 % of the gap and 4 % of the deceleration
/// here.
TEST(CoastingJoint, IsPlayWithItsDeceleration) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    Machine m(seed);
    m.sines[1].first *= 0.3;
    const double rate = m.sines[0].second[0], braking = m.sines[0].first * rate * rate;
    const TwoMasses masses{m.between(8, 60) * m.resolution, m.between(0.1, 0.7) * braking};
    const auto drive = [&](double t) { return m.along(Column::Constant(1, t))[0]; };
    const Column count = m.counted(m.along(m.time));
    m.path = masses.joint(m.time, drive);
    const Diagnosis d = diagnose(model_of(m), {}, {}, qerr::log_of(m, count));
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    const Effect& e = d.causes[0].effect;
    EXPECT_EQ(e.type, "backlash") << seed;
    EXPECT_NEAR(e.number("gap") / masses.gap, 1, 0.03) << seed;
    EXPECT_NEAR(e.number_or("deceleration", 0) / masses.friction, 1, 0.1) << seed;
    EXPECT_LT(d.gain.counts_after, 0.1 * d.gain.counts_before) << seed;
  }
}

/// An encoder on the load, and the drive's position as the reference.
TEST(CoastingJoint, IsSeenByTheEncoderOfTheLoad) {
  for (const unsigned seed : {11U, 12U, 13U}) {
    Machine m(seed);
    m.sines[1].first *= 0.3;
    m.path = m.along(m.time);
    const double rate = m.sines[0].second[0], braking = m.sines[0].first * rate * rate;
    const TwoMasses masses{m.between(8, 60) * m.resolution, m.between(0.1, 0.7) * braking};
    const auto drive = [&](double t) { return m.along(Column::Constant(1, t))[0]; };
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(masses.joint(m.time, drive))));
    ASSERT_FALSE(d.causes.empty()) << seed;
    const Effect& e = d.causes[0].effect;
    EXPECT_EQ(e.type, "backlash") << seed;
    EXPECT_EQ(e.choices.at("side"), "load") << seed;
    EXPECT_NEAR(e.number("gap") / masses.gap, 1, 0.03) << seed;
    EXPECT_NEAR(e.number_or("deceleration", 0) / masses.friction, 1, 0.1) << seed;
  }
}

/// A drive that crosses the play between two rows makes steps of whole counts, to and fro: they are no
/// losses.
TEST(CoastingJoint, IsNoLossOfCounts) {
  Machine m(5);
  m.rows = 8000, m.rate = 500, m.sines = {{0.5, {3.1, 0}}, {0.05, {10.7, 1}}};
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = m.along(m.time);
  const double h = 1e-4, gap = 26.1 * m.resolution, deceleration = 1.5;
  const Column after = m.along(m.time + h), before = m.along(m.time - h), speed = (after - before) / (2 * h);
  const Column force = (after + before - 2 * m.path) / (h * h) + deceleration * speed.sign();
  const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, m.counted(m.path + 0.5 * gap * force.sign())));
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_LT(d.gain.counts_after, 0.1 * d.gain.counts_before);
  EXPECT_EQ(d.causes[0].effect.type, "backlash");
  EXPECT_NEAR(d.causes[0].effect.number("gap") / gap, 1, 0.01);
}

}  // namespace
}  // namespace qerr
