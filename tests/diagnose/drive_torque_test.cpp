#include <gtest/gtest.h>

#include <cmath>

#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

/// An arm on a compliant gear, whose drive logs its own torque: what the gear transmits, and what the drive
/// needs for its friction and its rotor.
struct Drive {
  Machine machine;
  double weight = 0, inertia = 0, friction = 0, rotor = 0;  // [N m, kg m^2]
  Column load, torque;

  explicit Drive(unsigned seed) : machine(seed) {
    Machine& m = machine;
    m.rate = 500, m.rows = 10000, m.resolution = 2e-5, m.noise = 0.05 * m.resolution;
    m.sines = {{m.between(0.6, 1.1), {2 * std::numbers::pi * m.between(0.15, 0.3), m.between(0, 6)}},
               {m.between(0.1, 0.2), {2 * std::numbers::pi * m.between(0.5, 0.9), m.between(0, 6)}}};
    m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
    m.path = m.along(m.time);
    Column speed = Column::Zero(m.rows), change = speed;
    for (const auto& [a, wave] : m.sines) {
      speed += a * wave[0] * (wave[0] * m.time + wave[1]).cos();
      change -= a * wave[0] * wave[0] * (wave[0] * m.time + wave[1]).sin();
    }
    weight = m.between(3, 10), inertia = m.between(0.5, 1.5);
    friction = m.between(0.1, 0.3) * weight, rotor = m.between(0.2, 0.8) * inertia;
    load = weight * m.path.cos() + inertia * change;
    torque = load + friction * speed.sign() + rotor * change;
    for (double& t : torque) t += 0.005 * weight * m.normal();
  }

  Diagnosis diagnosed(double compliance) {
    return diagnose(model_of(machine), {}, {},
                    qerr::log_of({{LogSignal::time, machine.time},
                                  {LogSignal::counts, machine.counted(machine.path + compliance * load), 0},
                                  {LogSignal::reference, machine.reference()},
                                  {LogSignal::effort, torque, 6}}));
  }
};

/// Neither an eccentricity for the weight, nor a play for the friction.
TEST(DriveTorque, OfACompliantGearIsItsOnlyCause) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Drive drive(600 + seed);
    const double compliance = drive.machine.between(4, 15) * drive.machine.resolution / drive.weight;
    const Diagnosis d = drive.diagnosed(compliance);
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    const Effect& found = d.causes[0].effect;
    EXPECT_EQ(found.type, "compliance") << seed;
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    EXPECT_NEAR(found.number("compliance"), compliance, 0.03 * compliance) << seed;
    EXPECT_NEAR(found.number_or("friction", 0), drive.friction, 0.1 * drive.friction) << seed;
    EXPECT_NEAR(found.number_or("inertia", 0), drive.rotor, 0.2 * drive.rotor) << seed;
  }
}

/// Friction that nothing predicts: the load is then told by the link's own motion, and the product of
/// compliance and load better than either.
TEST(DriveTorque, ThatFrictionHidesIsALoadByTheLinksMotion) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Drive drive(620 + seed);
    Machine& m = drive.machine;
    double level = 0;
    for (Eigen::Index k = 0; k < m.rows; ++k) {  // its level changes from second to second
      level += -level / m.rate + std::sqrt(2 / m.rate) * m.normal();
      drive.torque[k] += drive.friction * level;
    }
    const double compliance = m.between(4, 15) * m.resolution / drive.weight;
    const Diagnosis d = drive.diagnosed(compliance);
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    const Effect& found = d.causes[0].effect;
    EXPECT_EQ(found.type, "compliance") << seed;
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    const double times = found.number("compliance"), of_inertia = times * found.number_or("load_inertia", 0);
    EXPECT_NEAR(of_inertia, compliance * drive.inertia, 0.05 * compliance * drive.inertia) << seed;
    EXPECT_NEAR(times * found.number_or("load_moment", 0), compliance * drive.weight,
                0.05 * compliance * drive.weight)
        << seed;
    EXPECT_NEAR(found.number_or("load_angle", 1), 0, 0.05) << seed;
    // The rotor's inertia counts as the link's.
    EXPECT_LT(times, 1.1 * compliance) << seed;
    EXPECT_GT(times, 0.9 * compliance * drive.inertia / (drive.inertia + drive.rotor)) << seed;
  }
}

/// The noise of the torque's measurement, times the compliance, is not in the readings.
TEST(DriveTorque, ThatIsNoisyMakesNoNoiseOfTheReadings) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Drive drive(640 + seed);
    for (double& t : drive.torque) t += 0.02 * drive.weight * drive.machine.normal();
    const Diagnosis d = drive.diagnosed(20 * drive.machine.resolution / drive.weight);
    ASSERT_EQ(d.causes.size(), 1U) << seed;
    EXPECT_EQ(d.causes[0].effect.type, "compliance") << seed;
  }
}

/// A usage has no acceleration: the effort's range would be a bound that the motion exceeds.
TEST(DriveTorque, DoesNotBoundAnOwnLoad) {
  Usage usage;
  usage.effort = Spread{-1, 1, 0, 1.0 / 3};
  const EffectKind& kind = effect_kind("compliance");
  EXPECT_NEAR(kind.share({"compliance", "q1", {{"compliance", 1e-5}}, {}}, {}, usage)->half_width, 1e-5,
              1e-15);
  for (const char* own : {"load_inertia", "load_moment"})
    EXPECT_FALSE(kind.share({"compliance", "q1", {{"compliance", 1e-5}, {own, 10}}, {}}, {}, usage)) << own;
}

TEST(DriveTorque, OfAStiffGearIsNoFault) {
  for (unsigned seed = 1; seed <= 2; ++seed)
    EXPECT_EQ(Drive(650 + seed).diagnosed(0).verdict, Verdict::nothing_wrong) << seed;
}

}  // namespace
}  // namespace qerr
