#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// Errors that no effect of the catalogue makes keep their own shape, and lend no effect a name.
namespace qerr {
namespace {

constexpr double turn = 2 * std::numbers::pi;

/// A table of even steps over whole turns, without time.
Diagnosis of_table(int rows, double resolution, const Column& error) {
  Machine m(1);
  m.resolution = resolution;
  m.path = Column::LinSpaced(rows, 0, (rows - 1) * turn / rows);
  return diagnose(
      model_of(m), {}, {},
      qerr::log_of({{LogSignal::counts, m.counted(m.path + error), 0}, {LogSignal::reference, m.path}}));
}

TEST(UncataloguedShapes, ATableOfEvenStepsShowsNoOrderAboveHalfItsRows) {
  for (const int rows : {48, 64, 100}) {
    const double resolution = turn / 16384;
    Column error(rows);
    for (int k = 0; k < rows; ++k)
      error[k] = resolution * (12 * std::sin(2 * turn * k / rows + 0.4) + 7 * std::sin(5 * turn * k / rows));
    const Diagnosis d = of_table(rows, resolution, error);
    EXPECT_FALSE(d.causes.empty() && d.unexplained.empty()) << rows;
    for (const Cause& c : d.causes) EXPECT_LE(c.effect.number_or("order", 0), rows / 2.0) << rows;
    for (const Unidentified& u : d.unexplained) EXPECT_LE(u.order.value_or(0), rows / 2.0) << rows;
  }
}

TEST(UncataloguedShapes, AnOrderOfConstantAmplitudeKeepsItsName) {
  constexpr int records = 3;
  int right = 0;
  for (unsigned seed = 1; seed <= records; ++seed) {
    Machine m(800 + seed);
    const double order = std::floor(m.between(30, 90)), size = m.between(3, 20) * m.resolution,
                 phase = m.between(0, turn);
    const Diagnosis d = diagnose(model_of(m), {}, {},
                                 qerr::log_of(m, m.counted(m.path + size * (order * m.path + phase).sin())));
    right += d.causes.size() == 1 && d.causes[0].effect.type == "transmission_error" &&
             d.causes[0].effect.number("order") == order;
  }
  EXPECT_GE(right, records - 1);
}

TEST(UncataloguedShapes, AChangeInProportionToTimeHasARate) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(900 + seed);
    const double rate = m.between(5, 40) * m.resolution * m.rate / m.rows;
    const Diagnosis d = diagnose(model_of(m), {}, {}, qerr::log_of(m, m.counted(m.path + rate * m.time)));
    ASSERT_EQ(d.unexplained.size(), 1U) << seed;
    const auto found = d.unexplained[0].figures.find("rate");
    ASSERT_NE(found, d.unexplained[0].figures.end()) << d.unexplained[0].what;
    EXPECT_NEAR(found->second, rate, 0.02 * rate) << seed;
    EXPECT_TRUE(d.causes.empty()) << seed;
  }
}

// A polynomial in time fits an exponential as well as a drift whose time constant is nearly right.
TEST(UncataloguedShapes, ADriftBesideAnOffsetKeepsItsName) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(950 + seed);
    const double size = m.between(10, 40) * m.resolution, offset = m.between(10, 40) * m.resolution,
                 constant = m.between(0.2, 0.9) * m.rows / m.rate;
    const Diagnosis d =
        diagnose(model_of(m), {}, {},
                 qerr::log_of(m, m.counted(m.path + offset + size * (1 - (-m.time / constant).exp()))));
    ASSERT_EQ(d.causes.size(), 2U) << seed;
    EXPECT_TRUE(d.unexplained.empty()) << seed;
    for (const Cause& c : d.causes) {
      const bool constant_one = c.effect.type == "offset";
      EXPECT_TRUE(constant_one || c.effect.type == "drift") << seed << ": " << c.effect.type;
      EXPECT_NEAR(c.effect.number(constant_one ? "offset" : "amplitude"), constant_one ? offset : size,
                  constant_one ? m.resolution : 0.1 * size)
          << seed;
    }
  }
}

/// What quantization and noise leave is known before anything is fitted.
TEST(UncataloguedShapes, DoNotRaiseWhatQuantizationAndNoiseLeave) {
  Machine m(41);
  m.noise = 0.05 * m.resolution;
  const Diagnosis d =
      diagnose(model_of(m), {}, {},
               qerr::log_of(m, m.counted(m.path + 20 * m.resolution * (0.11 * m.rate * m.time).sin())));
  EXPECT_NEAR(d.gain.counts_after / d.gain.sigma_ratio, std::sqrt(1 / 12.0 + 0.05 * 0.05), 0.02);
}

/// Friction with a soft drive (Dahl 1968) from a state that the record does not show.
TEST(UncataloguedShapes, AFrictionIsAHysteresisOfItsTravelAndNoPlay) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(950 + seed);
    const double travel = m.between(0.01, 0.3), size = 20 * m.resolution;
    Column state = Column::Constant(m.rows, m.between(-1, 1));
    for (Eigen::Index k = 1; k < m.rows; ++k) {
      const double by = m.path[k] - m.path[k - 1], side = by > 0 ? 1 : -1;
      state[k] = side + (state[k - 1] - side) * std::exp(-std::abs(by) / travel);
    }
    const Diagnosis d = diagnose(model_of(m), {}, {}, qerr::log_of(m, m.counted(m.path + size * state)));
    EXPECT_TRUE(d.causes.empty()) << seed << ' ' << (d.causes.empty() ? "" : d.causes[0].effect.type);
    ASSERT_EQ(d.unexplained.size(), 1U) << seed;
    EXPECT_EQ(d.unexplained[0].shape, Shape::hysteresis) << seed;
    EXPECT_NEAR(d.unexplained[0].figures.at("travel"), travel, 0.1 * travel) << seed;
  }
}

/// Play of a heavy load, which coasts from flank to flank where its drive brakes more than friction does.
/// What is left of it has a part of any column: no name but the play's stands alone.
TEST(UncataloguedShapes, APlayWithACoastingLoadHasNoOtherName) {
  constexpr double slow = 0.3, fast = 1.1, friction = 0.5;  // [Hz, Hz, of the rms torque]
  Machine m(31);
  m.rows = 4000, m.rate = 250, m.resolution = 2e-4, m.noise = 0.02 * m.resolution, m.centre = 0;
  m.sines = {{0.5, {2 * std::numbers::pi * slow, 0}}, {0.06, {2 * std::numbers::pi * fast, 1}}};
  m.time = Column::LinSpaced(m.rows, 0, m.rows - 1) / m.rate;
  m.path = m.along(m.time);
  const Column rate = (m.along(m.time + 1e-4) - m.along(m.time - 1e-4)) / 2e-4,
               torque = (m.along(m.time + 1e-3) - 2 * m.path + m.along(m.time - 1e-3)) / 1e-6;
  const double sliding = friction * std::sqrt(torque.square().mean()), flight = 0.08;
  Column side = (torque + sliding * rate.sign()).sign();
  for (Eigen::Index k = 1; k < m.rows; ++k)
    side[k] = std::clamp(side[k], side[k - 1] - flight, side[k - 1] + flight);
  const Diagnosis d =
      diagnose(model_of(m), {}, {}, qerr::log_of(m, m.counted(m.path + 30 * m.resolution * side)));
  EXPECT_FALSE(d.unexplained.empty());
  for (const Cause& c : d.causes) EXPECT_EQ(c.effect.type, "backlash");
}

/// Two joints of which the drive of the one moves the other.
TEST(Diagnosis, FindsACouplingThatWasLeftOut) {
  Machine first(51), second(52);
  second.rows = first.rows, second.rate = first.rate, second.time = first.time;
  second.path = second.along(second.time * (first.rate / second.rate));
  const double factor = 0.013;
  OperationalModel model = model_of(first);
  IndependentJoint joint;
  joint.name = "hand";
  model.chain.independent.push_back(joint);
  model.transmission.encoders.push_back({second.resolution});
  model.transmission.coupling = Eigen::MatrixXd::Identity(2, 2);
  Log log = qerr::log_of({{LogSignal::time, first.time},
                          {LogSignal::counts, first.counted(first.path), 0},
                          {LogSignal::reference, first.reference()},
                          {LogSignal::counts, second.counted(second.path + factor * first.path), 0},
                          {LogSignal::reference, second.reference()}});
  log.columns[3].index = log.columns[4].index = 1;
  const Diagnosis d = diagnose(model, {}, {}, std::move(log));
  ASSERT_EQ(d.causes.size(), 1U);
  EXPECT_EQ(d.verdict, Verdict::explained);
  EXPECT_EQ(d.causes[0].effect.type, "coupling_error");
  EXPECT_EQ(d.causes[0].effect.joint, "hand");
  EXPECT_EQ(d.causes[0].effect.choices.at("of"), "arm");
  EXPECT_NEAR(d.causes[0].effect.number("factor"), factor, 1e-4);
  EXPECT_LT(d.gain.counts_after, 0.35);
}

}  // namespace
}  // namespace qerr
