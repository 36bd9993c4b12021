#include "diagnose/record/sanity/sanity.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/one_joint_record.hpp"

namespace qerr {
namespace {

double worst(const Sanity& s, const Machine& m) {
  const auto counts = s.log.find(LogSignal::counts);
  return (s.log.values.col(*counts) * s.model.transmission.encoders[0].resolution - m.path).abs().maxCoeff();
}

TEST(Sanity, FindsNothingInCleanRecordsOfAnySizeAndRate) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Machine m(seed);
    if (seed % 2 == 0) {  // uneven instants, rightly stamped
      for (int k = 1; k < m.rows; ++k) m.time[k] += m.between(-0.3, 0.3) / m.rate;
      m.path = m.along(m.time);
    }
    const Column counts = m.counted(m.path);
    const Column velocity = controller_velocity(m, counts * m.resolution, 2, m.rate / 20);
    Column load = 20 * (m.path * 2).sin();
    for (double& x : load) x *= 1 + 0.01 * m.normal();
    const Log log = log_of({{LogSignal::time, m.time, 7},
                            {LogSignal::counts, counts, 0},
                            {LogSignal::reference, m.reference()},
                            {LogSignal::effort, load},
                            {LogSignal::command, m.path},
                            {LogSignal::velocity, velocity, 7}});
    const Sanity s = check_sanity(model_of(m), {first_order(m.rate, 2, m.rate / 20)}, log);
    EXPECT_TRUE(s.causes.empty()) << "seed " << seed << ": " << s.causes[0].effect.type;
    EXPECT_TRUE(s.unexplained.empty()) << "seed " << seed << ": " << s.unexplained[0].what;
    EXPECT_TRUE(s.cannot_judge.empty()) << s.cannot_judge;
    EXPECT_TRUE(s.warnings.empty()) << "seed " << seed;
    ASSERT_EQ(s.data.size(), seed % 2 == 0 ? 1u : 0u) << "seed " << seed << ": " << s.data[0].what;
    if (seed % 2 == 0) {
      EXPECT_NE(s.data[0].what.find("stamps are uneven"), std::string::npos);
    }
    EXPECT_TRUE((s.log.values == log.values).all()) << "seed " << seed;
  }
}

TEST(Sanity, FindsTheModulusOfARolloverAndUndoesIt) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path);
    const double most = counts.abs().maxCoeff();
    // A power of two, or the counts of a revolution; signed or unsigned.
    double modulus = std::exp2(std::floor(std::log2(1.6 * most)) - static_cast<double>(m.dice() % 3));
    if (seed % 3 == 0 && modulus > 1000) modulus = std::round(0.9 * modulus);
    const double shift = seed % 2 == 0 ? 0 : modulus / 2;
    const Column wrapped = counts.unaryExpr(
        [&](double c) { return c + shift - modulus * std::floor((c + shift) / modulus) - shift; });
    if ((wrapped == counts).all()) continue;
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, wrapped));
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed << ", " << modulus;
    EXPECT_EQ(s.causes[0].effect.type, "rollover");
    EXPECT_EQ(s.causes[0].effect.number("modulus"), modulus) << "seed " << seed;
    EXPECT_LT(worst(s, m), 0.51 * m.resolution) << "seed " << seed;
    EXPECT_GT(s.causes[0].gain.ratio(), 100);
  }
}

TEST(Sanity, FindsTheModulusOfASmallCounter) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Machine m(seed);
    const double modulus = std::array<double, 3>{32, 64, 128}[seed % 3];
    m.resolution = m.sines[0].first / (2 * modulus), m.noise = 0.05 * m.resolution;
    const Column counts = m.counted(m.path), wrapped = counts - modulus * (counts / modulus + 0.5).floor();
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, wrapped));
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.number("modulus"), modulus) << "seed " << seed;
    EXPECT_LT(worst(s, m), 0.51 * m.resolution) << "seed " << seed;
  }
}

/// Between the rows of a table, and of a fast motion, a counter may overflow more than once.
TEST(Sanity, FindsAnOverflowBetweenRowsThatAreFarApart) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const double modulus = std::array<double, 4>{64, 100, 256, 1000}[seed % 4];
    constexpr Eigen::Index n = 80;
    Column path(n);
    for (double& x : path) x = m.between(-3, 4) * modulus * m.resolution;
    const Column counts = m.counted(path), read = counts - modulus * (counts / modulus).floor();
    std::vector<Written> columns{{LogSignal::counts, read, 0}, {LogSignal::reference, path, 9}};
    if (seed % 2 == 0) columns.insert(columns.begin(), {LogSignal::time, m.time.head(n), 7});
    const Sanity s = check_sanity(model_of(m), {}, log_of(columns));
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.number("modulus"), modulus) << "seed " << seed;
    EXPECT_LT(s.causes[0].gain.rms_after, 0.6 * m.resolution) << "seed " << seed;
  }
}

/// A jump of the reference alone is none of the counter, however large, also beside a true overflow.
TEST(Sanity, DoesNotTreatSingleCellsOfTheReferenceAsOverflows) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path);
    const double modulus = std::exp2(std::floor(std::log2(1.6 * counts.abs().maxCoeff())));
    const Column wrapped =
        counts.unaryExpr([&](double c) { return c - modulus * std::floor(c / modulus + 0.5); });
    for (const Column& read : {counts, wrapped}) {
      Column reference = m.reference();
      const auto cell = static_cast<Eigen::Index>(m.dice() % static_cast<unsigned>(m.rows - 20)) + 10;
      reference[cell] += std::pow(10, m.between(0, 9)) * (seed % 2 == 0 ? 1 : -1);
      const Sanity s = check_sanity(model_of(m), {},
                                    log_of({{LogSignal::time, m.time, 7},
                                            {LogSignal::counts, read, 0},
                                            {LogSignal::reference, reference}}));
      ASSERT_EQ(s.causes.size(), (read == counts).all() ? 0u : 1u) << "seed " << seed;
      for (const Cause& c : s.causes) EXPECT_EQ(c.effect.number("modulus"), modulus) << "seed " << seed;
      EXPECT_TRUE(s.unexplained.empty()) << "seed " << seed;
      const bool found = std::any_of(s.data.begin(), s.data.end(), [&](const DataFinding& f) {
        return f.what.find("reference is far off") != std::string::npos &&
               f.row == static_cast<std::uint64_t>(cell) + 1;
      });
      EXPECT_TRUE(found) << "seed " << seed;
    }
  }
}

TEST(Sanity, FindsAReferenceThatDoesNotFollowTheEncoder) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const double size = std::pow(10, m.between(2, 6));
    Column noise = m.path, useful = m.path;
    for (double& x : noise) x = size * m.normal();
    for (double& x : useful) x += 0.2 * m.normal();  // more than a thousand counts, but it follows
    const auto checked = [&](const Column& reference) {
      return check_sanity(model_of(m), {},
                          log_of({{LogSignal::time, m.time, 7},
                                  {LogSignal::counts, m.counted(m.path), 0},
                                  {LogSignal::reference, reference}}));
    };
    const Sanity s = checked(noise);
    ASSERT_EQ(s.unexplained.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.unexplained[0].what, "the reference does not follow the encoder");
    EXPECT_FALSE(s.log.find(LogSignal::reference, 0));
    EXPECT_TRUE(checked(useful).unexplained.empty()) << "seed " << seed;
  }
}

// One channel of a quadrature encoder is dead from a time on: each edge of the other one counts to and fro.
TEST(Sanity, FindsADeadChannelOfAQuadratureEncoder) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Machine m(seed);
    Column counts = m.counted(m.path);
    const Eigen::Index since = m.rows / 3 + static_cast<Eigen::Index>(m.dice() % 500);
    const double last = counts[since];
    for (Eigen::Index k = since; k < counts.size(); ++k)
      counts[k] = last + (std::fmod(std::floor(counts[k] / 2) - std::floor(last / 2), 2) != 0);
    const Diagnosis d = diagnose(model_of(m), {}, {}, log_of(m, counts));
    EXPECT_TRUE(d.causes.empty()) << "seed " << seed << ": " << d.causes[0].effect.type;
    ASSERT_EQ(d.unexplained.size(), 1u) << "seed " << seed;
    EXPECT_NE(d.unexplained[0].what.find("to and fro between two counts"), std::string::npos) << seed;
  }
}

// While the drive crosses the play the joint stands: its readings alone tell where it is.
TEST(Diagnosis, MeasuresAPlayByTheReadingsThatDriveIt) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m(seed);
    const double gap = m.between(4, 40) * m.resolution;
    Column motor = m.path, joint = m.path;
    double at = motor[0];
    for (Eigen::Index k = 0; k < motor.size(); ++k)
      joint[k] = at = std::min(std::max(at, motor[k] - gap / 2), motor[k] + gap / 2);
    Column reference = joint;
    for (double& x : reference) x += m.noise * m.normal();
    const Log log = log_of({{LogSignal::time, m.time},
                            {LogSignal::counts, m.counted(motor), 0},
                            {LogSignal::reference, reference}});
    const Diagnosis d = diagnose(model_of(m), {}, {}, log);
    ASSERT_EQ(d.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(d.causes[0].effect.type, "backlash") << seed;
    EXPECT_NEAR(d.causes[0].effect.number("gap"), gap, 0.02 * gap + 0.1 * m.resolution) << seed;
    EXPECT_EQ(d.verdict, Verdict::explained) << seed;
    EXPECT_EQ(diagnose(model_of(m), {}, {d.causes[0].effect}, log).verdict, Verdict::nothing_wrong) << seed;
  }
}

// A current is the load's, the friction's and the rotor's; the gear's load is gravity's and the link's.
TEST(Diagnosis, MeasuresAComplianceByTheCurrentOfTheMotor) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m(seed);
    m.sines[0].first = m.between(0.7, 1.2);
    m.path = m.along(m.time);
    const auto derivative = [&](const Column& x) {
      Column d = Column::Zero(x.size());
      const Eigen::Index n = x.size() - 2;
      d.segment(1, n) = (x.tail(n) - x.head(n)) * (m.rate / 2);
      d[0] = d[1], d[n + 1] = d[n];
      return d;
    };
    const Column speed = derivative(m.path), acceleration = derivative(speed);
    const double torque = m.between(5, 60);
    const Column load = torque * m.path.sin() + 0.1 * torque * acceleration / acceleration.abs().maxCoeff();
    const double compliance = m.between(5, 30) * m.resolution / torque;
    Column effort = load + 0.3 * torque * (speed / (0.01 * speed.abs().maxCoeff())).tanh() +
                    0.2 * torque * speed / speed.abs().maxCoeff();
    for (double& e : effort) e += 0.02 * torque * m.normal();
    const Log log = log_of({{LogSignal::time, m.time},
                            {LogSignal::counts, m.counted(m.path + compliance * load), 0},
                            {LogSignal::reference, m.reference()},
                            {LogSignal::effort, effort}});
    const Diagnosis d = diagnose(model_of(m), {}, {}, log);
    const auto is_compliance = [](const auto& effect) { return effect == "compliance"; };
    const bool named = std::any_of(d.causes.begin(), d.causes.end(),
                                   [&](const Cause&c) { return is_compliance(c.effect.type); }),
               offered = std::any_of(d.alternatives.begin(), d.alternatives.end(),
                                     [&](const AlternativeCause&a) { return is_compliance(a.effect); });
    EXPECT_TRUE(named || offered) << "seed " << seed;
    if (named && d.causes.size() == 1) {
      EXPECT_NEAR(d.causes[0].effect.number("compliance"), compliance, 0.1 * compliance) << seed;
    }
  }
}

// The counter of a reversed gear falls while the joint rises: its missed counts are the counter's own.
TEST(Diagnosis, ReportsMissedCountsOfTheCounterBehindAReversedGear) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    Machine m(seed);
    OperationalModel model = model_of(m);
    model.transmission.encoders[0].shaft_ratio = -1;
    const double missed = (seed % 2 == 0 ? 4 : -6), half = m.time[m.rows / 2];
    Column counts = m.counted(m.path);  // of a log, rising with the joint
    for (Eigen::Index k = m.rows / 2; k < counts.size(); ++k) counts[k] -= missed;
    const Diagnosis d = diagnose(model, {}, {}, log_of(m, counts));
    ASSERT_EQ(d.causes.size(), 1u) << "seed " << seed << ": " << d.causes[0].effect.type << ", "
                                   << d.causes[1].effect.type;
    EXPECT_EQ(d.causes[0].effect.type, "missed_counts") << seed;
    EXPECT_NEAR(d.causes[0].effect.number("counts"), missed, 0.1) << seed;
    EXPECT_NEAR(d.causes[0].effect.number("time"), half, 0.1) << seed;
  }
}

TEST(Sanity, FollowsAWrappingCounterWithoutAReference) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path);
    const double modulus = std::exp2(std::floor(std::log2(1.6 * counts.abs().maxCoeff())));
    const Column wrapped =
        counts.unaryExpr([&](double c) { return c - modulus * std::floor(c / modulus + 0.5); });
    if ((wrapped == counts).all()) continue;
    Log log = log_of({{LogSignal::time, m.time}, {LogSignal::counts, wrapped, 0}, {LogSignal::tip, m.path}});
    const Sanity s = check_sanity(model_of(m), {}, log);
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.number("modulus"), modulus);
    const Column whole = s.log.values.col(1);
    EXPECT_EQ((whole - counts - (whole[0] - counts[0])).abs().maxCoeff(), 0) << "seed " << seed;
  }
}

TEST(Sanity, DoesNotChangeMissedCounts) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Machine m(seed);
    Column counts = m.counted(m.path);
    const double lost = std::round(m.between(1, 700)) * (seed % 2 ? 1 : -1);
    const Eigen::Index at = m.rows / 3 + static_cast<Eigen::Index>(m.dice() % 500);
    counts.tail(m.rows - at) += lost;
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, counts));
    EXPECT_TRUE(s.causes.empty()) << "seed " << seed << ", " << lost
                                  << " counts: " << s.causes[0].effect.type;
  }
}

TEST(Sanity, FindsTheFactorOfAWrongDecodingAlsoWithAScaleError) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Machine m(seed);
    const double factor = std::array<double, 7>{0.25, 0.5, 2, 4, -1, -0.5, -0.25}[seed % 7];
    m.path *= 1 + (seed % 2) * 0.004;
    const Column counts = (factor * m.counted(m.path) + 0.5).floor();
    m.path /= 1 + (seed % 2) * 0.004;
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, counts));
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.type, "decoding");
    EXPECT_EQ(s.causes[0].effect.number("factor"), factor) << "seed " << seed;
    // The counter's step: larger if edges are skipped, never finer than the counts.
    const double step = m.resolution * std::max(1.0, 1 / std::abs(factor));
    EXPECT_NEAR(s.model.transmission.encoders[0].resolution, step, 1e-12);
    if (seed % 2 == 0) {
      EXPECT_LT(worst(s, m), 0.5001 * step) << "seed " << seed << ", factor " << factor;
    }
  }
}

TEST(Sanity, TreatsAFewPercentAsScaleAndNotAsDecoding) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path * (1 + m.between(-0.06, 0.06)));
    EXPECT_TRUE(check_sanity(model_of(m), {}, log_of(m, counts)).causes.empty()) << "seed " << seed;
  }
}

TEST(Sanity, ReportsTheLogResolutionAndRestoresTheCountsIfPossible) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const double decade = std::ceil(-std::log10(m.resolution));
    const Column measured = m.counted(m.path) * m.resolution;
    const auto found = [&](int decimals) {
      return check_sanity(model_of(m), {},
                          log_of({{LogSignal::time, m.time},
                                  {LogSignal::measured, measured, decimals},
                                  {LogSignal::reference, m.reference()}}));
    };
    const Sanity coarse = found(static_cast<int>(decade) - 1), fine = found(static_cast<int>(decade) + 3);
    ASSERT_EQ(coarse.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(coarse.causes[0].effect.type, "log_rounding");
    EXPECT_NEAR(coarse.causes[0].effect.number("step") / std::pow(10, 1 - decade), 1, 1e-9);
    EXPECT_TRUE(fine.causes.empty()) << "seed " << seed;
    const Sanity between = found(static_cast<int>(decade));
    if (between.causes.empty() || std::pow(10, -decade) > 0.49 * m.resolution) continue;
    EXPECT_LT((between.log.values.col(1) - measured).abs().maxCoeff(), 1e-12) << "seed " << seed;
  }
}

/// A reference at a speed and a rate that are round numbers: its few decimals are all it has.
TEST(Sanity, TakesASteadySpeedForNoRounding) {
  for (const double per_row : {1e-3, 5e-4, 0.02}) {
    Machine m(3);
    m.resolution = 4.8e-5;
    m.path = per_row * Column::LinSpaced(m.rows, 0, m.rows - 1);
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time},
                                          {LogSignal::counts, m.counted(m.path), 0},
                                          {LogSignal::reference, m.path, 4}}));
    EXPECT_TRUE(s.causes.empty()) << per_row;
    EXPECT_TRUE(s.warnings.empty()) << per_row;
  }
}

/// Counts of an absolute encoder with a counter of turns, of which a leap was taken for a wrap.
TEST(Sanity, PutsBackTurnsThatWereNoWraps) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Machine m(seed);
    m.resolution = 2 * std::numbers::pi / 16384 / 50;
    const Column counts = m.counted(m.path);
    Column unwrapped = counts;
    unwrapped.tail(m.rows - 1 - static_cast<int>(seed)) += seed % 2 ? 16384 : -16384;
    Log log = log_of(m, unwrapped);
    log.columns[1].wraps = {0, 1, seed + 1, 0, true};
    OperationalModel model = model_of(m);
    model.transmission.encoders[0].shaft_ratio = 50;
    const Sanity s = check_sanity(model, {}, std::move(log));
    EXPECT_TRUE((s.log.values.col(1) == counts).all()) << seed;
    EXPECT_TRUE(s.causes.empty()) << seed;
  }
}

TEST(Sanity, DetectsACounterThatUsesOnlyEveryFourthCount) {
  for (const double drift : {0.0, 200.0}) {  // counts, beside which the rounding is small
    Machine m(4);
    const Column read = m.path + drift * m.resolution * m.time / m.time[m.rows - 1];
    const Column counts = 4 * (m.counted(read) / 4 + 0.5).floor();
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, counts));
    ASSERT_EQ(s.causes.size(), 1u) << drift;
    EXPECT_EQ(s.causes[0].effect.type, "log_rounding");
    EXPECT_NEAR(s.causes[0].effect.number("step"), 4 * m.resolution, 1e-12);
  }
}

/// A reference that is computed from the readings confirms them, whatever they are.
TEST(Sanity, RejectsAReferenceThatIsACopyOfTheReadings) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const OperationalModel model = model_of(m);
    const Column counts = m.counted(m.path);
    const Sanity s = check_sanity(
        model, {},
        log_of({{LogSignal::time, m.time},
                {LogSignal::counts, counts, 0},
                {LogSignal::reference, counts * model.transmission.encoders[0].resolution + seed % 3}}));
    EXPECT_FALSE(s.log.find(LogSignal::reference)) << seed;
    EXPECT_FALSE(s.cannot_judge.empty()) << seed;
    ASSERT_FALSE(s.data.empty()) << seed;
    EXPECT_EQ(s.data.back().kind, DataKind::contradictory) << seed;
  }
}

/// A motor that has to take up a play stays behind by as much as the joint moves at first.
TEST(Sanity, TakesTheFirstStateOfAPlayForNoCorruptReading) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const OperationalModel model = model_of(m);
    const double step = model.transmission.encoders[0].resolution, fast = (10 + seed) * step;
    for (Eigen::Index k = 0; k < m.rows; ++k) m.path[k] = fast * static_cast<double>(k);
    const auto with_first = [&](double error) {
      Column read = m.path;
      read.tail(m.rows - 1) -= 0.9 * fast;
      read[0] += error;
      const Sanity s = check_sanity(model, {},
                                    log_of({{LogSignal::time, m.time},
                                            {LogSignal::counts, m.counted(read), 0},
                                            {LogSignal::reference, m.reference()}}));
      return std::count_if(s.data.begin(), s.data.end(),
                           [](const DataFinding& f) { return f.kind == DataKind::corrupt; });
    };
    EXPECT_EQ(with_first(0), 0) << seed;
    EXPECT_EQ(with_first(20 * fast), 1) << seed;
  }
}

/// In a play that the record shows in both directions, the first reading may be anywhere.
TEST(Sanity, TakesAFirstReadingWithinThePlayForNoCorruptOne) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Machine m(seed);
    const double gap = 200 * (m.path.tail(m.rows - 1) - m.path.head(m.rows - 1)).abs().maxCoeff();
    Column read = m.path;
    for (Eigen::Index k = 1; k < m.rows; ++k) read[k] += m.path[k] > m.path[k - 1] ? gap / 2 : -gap / 2;
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time},
                                          {LogSignal::counts, m.counted(read), 0},
                                          {LogSignal::reference, m.reference()}}));
    for (const DataFinding& f : s.data) EXPECT_NE(f.kind, DataKind::corrupt) << seed << ": " << f.what;
  }
}

TEST(Sanity, TakesAStuckBitFromTheReference) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Machine m(seed);
    const int bit = static_cast<int>(seed % 4);
    const bool one = seed % 3 == 0;
    const Column whole = m.counted(m.path);
    const Column read = whole.unaryExpr([&](double count) {
      const auto c = static_cast<std::int64_t>(count), mask = std::int64_t{1} << bit;
      return static_cast<double>(one ? c | mask : c & ~mask);
    });
    const auto sanity_of = [&](const Column& counts) {
      return check_sanity(model_of(m), {},
                          log_of({{LogSignal::time, m.time},
                                  {LogSignal::counts, counts, 0},
                                  {LogSignal::reference, m.reference()}}));
    };
    const auto stuck = [](const Sanity& s) {
      return std::count_if(s.data.begin(), s.data.end(), [](const DataFinding& f) {
        return f.what.find("of the counts never changes") != std::string::npos;
      });
    };
    const Sanity s = sanity_of(read);
    ASSERT_EQ(stuck(s), 1) << seed;
    EXPECT_NE(s.data.front().what.find("bit " + std::to_string(bit) + " of"), std::string::npos);
    const Column counts = s.log.values.col(*s.log.find(LogSignal::counts, 0));
    if (bit == 0)  // judged in steps of two counts
      EXPECT_LE((2 * counts - m.path / m.resolution).abs().maxCoeff(), 1.001) << seed;
    else
      EXPECT_TRUE((counts == whole).all()) << seed;
    EXPECT_EQ(stuck(sanity_of(whole)), 0) << seed;
  }
}

/// With a reference some passages between two halves tell, in a log as in a table.
TEST(Sanity, TakesAStuckBitOfFewHalvesFromTheReference) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Machine m(seed);
    const Column whole = m.counted(m.path);
    const int bit = static_cast<int>(std::log2(whole.maxCoeff() - whole.minCoeff())) - 1;
    const auto mask = std::int64_t{1} << bit;
    const Column read = whole.unaryExpr([&](double count) {
      const auto c = static_cast<std::int64_t>(count);
      return static_cast<double>(seed % 3 == 0 ? c | mask : c & ~mask);
    });
    std::vector<Written> columns{{LogSignal::counts, read, 0}, {LogSignal::reference, m.reference()}};
    if (seed % 2 == 0) columns.insert(columns.begin(), {LogSignal::time, m.time});
    const Sanity s = check_sanity(model_of(m), {}, log_of(columns));
    ASSERT_EQ(s.causes.size(), 1u) << seed;
    EXPECT_EQ(s.causes[0].effect.type, "stuck_bit") << seed;
    EXPECT_EQ(s.causes[0].effect.number("bit"), bit) << seed;
    EXPECT_EQ(s.causes[0].effect.number("value"), seed % 3 == 0) << seed;
    EXPECT_LT(s.causes[0].gain.rms_after, 0.4 * m.resolution) << seed;
  }
}

/// Odd counts are those of a stuck bit, positions rounded to two counts are not displaced, and else a counter
/// of every second edge does the same.
TEST(Sanity, HedgesWhatMakesAllCountsEven) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Machine m(seed);
    const Column whole = m.counted(m.path);
    const auto said = [&](const Column& counts) {
      const Sanity s = check_sanity(
          model_of(m), {}, log_of({{LogSignal::counts, counts, 0}, {LogSignal::reference, m.reference()}}));
      std::string all;
      for (const Cause& c : s.causes) all += c.effect.type;
      for (const AlternativeCause& a : s.alternatives) all += " or " + a.effect;
      return all;
    };
    EXPECT_EQ(said(2 * (0.5 * whole).floor() + 1), "stuck_bit") << seed;
    EXPECT_EQ(said(2 * (0.5 * whole).floor()), "stuck_bit or log_rounding") << seed;
    EXPECT_EQ(said(2 * (0.5 * m.path / m.resolution + 0.5).floor()), "log_rounding") << seed;
  }
}

/// A table's rows have no order: the values alone show the grid of a rounded reference, and of even steps
/// that are rounded, too.
TEST(Sanity, FindsTheGridOfATablesReference) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Machine m(seed);
    const double step = std::exp(m.between(0.3, 4)) * m.resolution, apart = m.between(1.3, 9) * step;
    const bool even = seed % 3 == 0;
    const Column positions = Column::NullaryExpr(200, [&](Eigen::Index k) {
      return even ? static_cast<double>(k) * apart : m.between(0, 20000) * step;
    });
    const auto grid = [&](const Column& reference) {
      const Sanity s = check_sanity(
          model_of(m), {},
          log_of({{LogSignal::counts, m.counted(positions), 0}, {LogSignal::reference, reference}}));
      const Column left = s.log.values.col(1) - s.log.values.col(0) * m.resolution;
      if (even) {
        EXPECT_LT(left.abs().maxCoeff(), 0.2 * step + 0.6 * m.resolution) << seed;
      }
      return s.reference_grid[0];
    };
    EXPECT_NEAR(grid(step * (positions / step + 0.5).floor()), step, 1e-3 * step) << seed;
    EXPECT_EQ(grid(positions), 0) << seed;
  }
}

TEST(Sanity, ReportsConstantSensors) {
  Machine m(7);
  const Column counts = m.counted(m.path);
  const Sanity encoder = check_sanity(model_of(m), {}, log_of(m, Column::Constant(m.rows, 12)));
  ASSERT_EQ(encoder.unexplained.size(), 1u);
  EXPECT_FALSE(encoder.log.find(LogSignal::counts));
  const Sanity reference = check_sanity(model_of(m), {},
                                        log_of({{LogSignal::time, m.time},
                                                {LogSignal::counts, counts, 0},
                                                {LogSignal::reference, Column::Constant(m.rows, 0.3)}}));
  EXPECT_FALSE(reference.cannot_judge.empty());
  EXPECT_EQ(reference.warnings.size(), 1u);
  EXPECT_TRUE(reference.causes.empty());
}

TEST(Sanity, ExcludesTheRowsOfAStuckSensor) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    Column counts = m.counted(m.path);
    const Eigen::Index at = m.rows / 4 + static_cast<Eigen::Index>(m.dice() % 300);
    const Eigen::Index length = m.rows / 8;
    if (std::abs(counts[at + length] - counts[at]) < 40) continue;
    counts.segment(at, length).setConstant(counts[at]);
    const Sanity s = check_sanity(model_of(m), {}, log_of(m, counts));
    ASSERT_EQ(s.unexplained.size(), 1u) << "seed " << seed;
    // Neighbouring rows of the same count are excluded as well.
    EXPECT_LE(s.log.values.rows(), m.rows - length + 1) << "seed " << seed;
    EXPECT_GT(s.log.values.rows(), m.rows - length - m.rows / 50) << "seed " << seed;
  }
}

/// A reading that is ahead in time rests before its reference.
TEST(Sanity, TakesAnEarlyRestForNoStuckSensor) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Machine m(seed);
    const Eigen::Index early = m.rows / 100, rest = m.rows / 20;
    Column path = m.path;
    path.tail(rest).setConstant(path[m.rows - rest]);
    m.path = path;
    path.head(m.rows - early) = m.path.tail(m.rows - early);
    EXPECT_TRUE(check_sanity(model_of(m), {}, log_of(m, m.counted(path))).unexplained.empty()) << seed;
  }
}

bool stands_still(const Sanity& s) {
  return std::any_of(s.data.begin(), s.data.end(), [](const DataFinding& f) {
    return f.kind == DataKind::repeated && f.what.starts_with("the reference stands still");
  });
}

TEST(Sanity, LeavesOutTheRowsInWhichAReferenceIsFrozen) {
  int tried = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Machine m(seed);
    Column reference = m.reference();
    // It may return to where the reference is: no jump at the end.
    const Eigen::Index length = m.rows / 20 + static_cast<Eigen::Index>(m.dice() % (m.rows / 8)),
                       at = m.rows / 4 + static_cast<Eigen::Index>(m.dice() % (m.rows / 2));
    if (const Column part = m.path.segment(at, length); part.maxCoeff() - part.minCoeff() < 30 * m.resolution)
      continue;
    reference.segment(at, length).setConstant(reference[at]);
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time},
                                          {LogSignal::counts, m.counted(m.path), 0},
                                          {LogSignal::reference, reference}}));
    EXPECT_TRUE(stands_still(s)) << seed;
    EXPECT_EQ(s.log.values.rows(), m.rows - length) << seed;
    ++tried;
  }
  EXPECT_GT(tried, 20);
}

TEST(Sanity, LeavesACoupledEncoderWithoutTheReferencesOfAllItsJointsAlone) {
  Machine m(3);
  OperationalModel model = model_of(m);
  model.chain.independent.push_back(model.chain.independent[0]);
  model.chain.independent[1].name = "wrist";
  model.transmission.encoders.push_back(model.transmission.encoders[0]);
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Identity(2, 2);
  coupling(0, 1) = 0.5;
  model.transmission.coupling = coupling;
  const Sanity s = check_sanity(model, {}, log_of(m, m.counted(m.path)));
  EXPECT_FALSE(stands_still(s));
}

TEST(Sanity, TakesNoPlayForAFrozenReference) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Machine m(seed);
    const double width = m.between(20, 2000) * m.resolution;
    const Eigen::Index end = m.rows / 4 + static_cast<Eigen::Index>(m.dice() % (3 * m.rows / 4));
    Column joint = m.path.head(end);
    joint[0] += m.between(-0.5, 0.5) * width;
    for (Eigen::Index k = 1; k < end; ++k)
      joint[k] = std::clamp(joint[k - 1], m.path[k] - width / 2, m.path[k] + width / 2);
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time.head(end)},
                                          {LogSignal::counts, m.counted(m.path).head(end), 0},
                                          {LogSignal::reference, joint}}));
    EXPECT_FALSE(stands_still(s)) << seed;
  }
}

TEST(Sanity, RestoresRoundedStampsAndReportsGapsAndDuplicates) {
  Machine m(5);
  const Column counts = m.counted(m.path);
  const auto found = [&](const Column& time, int decimals) {
    return check_sanity(model_of(m), {},
                        log_of({{LogSignal::time, time, decimals},
                                {LogSignal::counts, counts, 0},
                                {LogSignal::reference, m.reference()}}));
  };
  const Sanity rounded = found(m.time, m.rate > 600 ? 3 : 2);
  EXPECT_LT((rounded.log.values.col(0) - rounded.log.values(0, 0) - m.time).abs().maxCoeff(),
            0.03 / m.rate * 20);
  Column gap = m.time;
  gap.tail(m.rows / 2) += 100 / m.rate;
  ASSERT_FALSE(found(gap, 7).data.empty());
  EXPECT_NE(found(gap, 7).data[0].what.find("gap"), std::string::npos);
  EXPECT_EQ(found(gap, 7).data[0].row, static_cast<std::uint64_t>(m.rows - m.rows / 2 + 1));
  Column doubled = m.time;
  for (int k = 10; k < m.rows; k += 50) doubled[k] = doubled[k - 1];
  ASSERT_FALSE(found(doubled, 7).data.empty());
  EXPECT_NE(found(doubled, 7).data[0].what.find("stamp of the previous row"), std::string::npos);
  const Sanity same = found(Column::Zero(m.rows), 7);
  EXPECT_FALSE(same.log.has_time());
}

TEST(Sanity, DoesNotTreatAControllersErrorAsLoad) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Machine m(seed);
    const Column lag = m.along(m.time - 2 / m.rate), counts = m.counted(lag);
    if ((lag - m.path).abs().maxCoeff() < 5 * m.resolution) continue;
    const double gain = m.between(20, 300);
    // The set point is the reference, and the effort is the gain times the servo error.
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time},
                                          {LogSignal::counts, counts, 0},
                                          {LogSignal::reference, m.path, 12},
                                          {LogSignal::effort, gain * (m.path - counts * m.resolution), 12}}));
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.type, "controller_droop");
    EXPECT_FALSE(s.log.find(LogSignal::effort));
    const Sanity by_command = check_sanity(model_of(m), {},
                                           log_of({{LogSignal::time, m.time},
                                                   {LogSignal::counts, counts, 0},
                                                   {LogSignal::reference, lag},
                                                   {LogSignal::command, m.path},
                                                   {LogSignal::effort, gain * (m.path - lag)}}));
    EXPECT_TRUE(by_command.causes.empty());
    EXPECT_FALSE(by_command.log.find(LogSignal::effort)) << "seed " << seed;
  }
}

TEST(Sanity, IdentifiesTheFilterOfTheVelocity) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Machine m(seed);
    const int order = 1 + static_cast<int>(seed % 3);
    const double stated = m.rate / 20, real = stated * std::array<double, 3>{0.3, 0.5, 3}[seed % 3];
    const Column counts = m.counted(m.path);
    const Log log =
        log_of({{LogSignal::time, m.time, 7},
                {LogSignal::counts, counts, 0},
                {LogSignal::reference, m.reference()},
                {LogSignal::velocity, controller_velocity(m, counts * m.resolution, order, real), 7}});
    const Sanity s = check_sanity(model_of(m), {first_order(m.rate, order, stated)}, log);
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.type, "filter_mismatch");
    EXPECT_EQ(s.causes[0].effect.number("order"), order);
    EXPECT_NEAR(s.causes[0].effect.number("cutoff") / real, 1, 0.02);
  }
}

TEST(Sanity, JudgesAVelocityWithoutKnowingItsFilter) {
  struct Fault {
    std::string_view said;
    Column (*spoil)(const Column&, Machine&);
  };
  const Fault faults[] = {
      {"", [](const Column& v, Machine&) { return v; }},
      {"opposite sign", [](const Column& v, Machine&) { return Column(-v); }},
      {"looks like deg/s", [](const Column& v, Machine&) { return Column(v * (180 / std::numbers::pi)); }},
      {"looks like rpm", [](const Column& v, Machine&) { return Column(v * (30 / std::numbers::pi)); }},
      {"times that of the motion", [](const Column& v, Machine& m) { return Column(v * m.between(20, 50)); }},
      {"offset", [](const Column& v,
                    Machine& m) { return Column(v + m.between(0.05, 0.5) * std::sqrt(v.square().mean())); }},
      {"constant", [](const Column& v, Machine&) { return Column(Column::Constant(v.size(), v[0])); }},
      {"wraps",
       [](const Column& v, Machine& m) {
         const double interval = v.abs().maxCoeff() * m.between(1.2, 1.8);
         return Column(v - interval * (v / interval).round());
       }},
      {"does not follow", [](const Column& v, Machine& m) {
         Column other = Machine(static_cast<unsigned>(m.dice() % 1000) + 1000).path;
         return Column(other.head(1500).replicate(v.size() / 1500 + 1, 1).col(0).head(v.size()));
       }}};
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const Fault& fault : faults) {
      Machine m(seed);
      const Column counts = m.counted(m.path);
      const Column clean = controller_velocity(m, counts * m.resolution, 2, m.rate / 20);
      const Sanity s = check_sanity(model_of(m), {},
                                    log_of({{LogSignal::time, m.time, 7},
                                            {LogSignal::counts, counts, 0},
                                            {LogSignal::reference, m.reference()},
                                            {LogSignal::velocity, fault.spoil(clean, m), 7}}));
      ASSERT_EQ(s.data.size(), fault.said.empty() ? 0u : 1u) << seed << ' ' << fault.said;
      if (!fault.said.empty()) {
        EXPECT_NE(s.data[0].what.find(fault.said), std::string::npos) << seed << ' ' << s.data[0].what;
      }
    }
}

TEST(Sanity, DetectsUnevenSamplingFromTheVelocityAlone) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Machine m(seed);
    for (int k = 1; k < m.rows; ++k) m.time[k] = m.time[k - 1] + (m.dice() % 3 ? 1.0 : 1.2) / m.rate;
    m.path = m.along(m.time);
    Column speed = Column::Zero(m.rows);
    for (const auto& [a, wave] : m.sines) speed += a * wave[0] * (wave[0] * m.time + wave[1]).cos();
    const Column steps = m.time.tail(m.rows - 1) - m.time.head(m.rows - 1);
    const double sigma = std::sqrt((steps - steps.mean()).square().mean());
    if (speed.abs().maxCoeff() * sigma < 3 * m.resolution) continue;
    const Log log = log_of({{LogSignal::time, m.time, 7},
                            {LogSignal::measured, m.counted(m.path) * m.resolution},
                            {LogSignal::velocity, speed, 5}});
    const Sanity s = check_sanity(model_of(m), {first_order(m.rate, 1, m.rate / 20)}, log);
    EXPECT_FALSE(s.cannot_judge.empty());
    ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed;
    EXPECT_EQ(s.causes[0].effect.type, "timing_jitter");
    EXPECT_NEAR(s.causes[0].effect.number("sigma") / sigma, 1, 0.02);
  }
}

TEST(Sanity, DoesNotUseTheStampsOfSinglePoses) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const bool poses = seed % 2 == 0;
    m.time *= 2 * m.rate;  // a row every two seconds
    if (poses)
      for (double& x : m.path) x = m.between(-2, 2);
    const Sanity s = check_sanity(model_of(m), {},
                                  log_of({{LogSignal::time, m.time},
                                          {LogSignal::counts, m.counted(m.path), 0},
                                          {LogSignal::reference, m.reference()}}));
    EXPECT_EQ(s.log.has_time(), !poses) << seed;
    EXPECT_EQ(s.data.size(), poses ? 1u : 0u) << seed;
  }
}

TEST(Sanity, AcceptsTablesWithoutTime) {
  Machine m(9);
  const Log log = log_of({{LogSignal::counts, m.counted(m.path), 0}, {LogSignal::reference, m.path}});
  const Sanity s = check_sanity(model_of(m), {first_order(1000, 2, 50)}, log);
  EXPECT_TRUE(s.causes.empty());
  EXPECT_TRUE(s.warnings.empty());
  ASSERT_EQ(s.log.values.rows(), log.values.rows());
  for (Eigen::Index k = 0; k < log.values.rows(); ++k) {
    const auto row = static_cast<Eigen::Index>(s.log.row_number(k));
    EXPECT_TRUE((s.log.values.row(k) == log.values.row(row)).all()) << k;
  }
}

// Once sorted they are steady; as they come, they look like rounding, like a stuck bit and like a coarse
// reference.
TEST(Sanity, FindsNothingInATableAtEvenStepsOfSeveralCounts) {
  for (const double counts : {4.005, 8.0013, 31.999, 55.98}) {
    Machine m(9);
    for (Eigen::Index k = 0; k < m.path.size(); ++k)
      m.path[k] = static_cast<double>(7 * k % 200) * counts * m.resolution;
    const Sanity s = check_sanity(
        model_of(m), {}, log_of({{LogSignal::counts, m.counted(m.path), 0}, {LogSignal::reference, m.path}}));
    EXPECT_TRUE(s.causes.empty()) << counts;
    EXPECT_TRUE(s.data.empty()) << counts << ": " << (s.data.empty() ? "" : s.data[0].what);
  }
}

}  // namespace
}  // namespace qerr
