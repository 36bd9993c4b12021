#include <gtest/gtest.h>

#include "diagnose/record/sanity/sanity.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// Records of a machine whose effects are in the spec.
namespace qerr {
namespace {

Effect effect_of(const char* type, const char* parameter, double value) {
  return {type, "arm", {{parameter, value}}, {}};
}

/// The rollover of a two's complement counter.
Column wrapped(const Column& counts, double modulus) {
  return counts - modulus * (counts / modulus + 0.5).floor();
}

/// The largest power of two below the range of the motion.
double narrow(const Column& counts) {
  return std::exp2(std::floor(std::log2(1.6 * counts.abs().maxCoeff())));
}

std::string causes(const Diagnosis& d) {
  std::string text;
  for (const Cause& c : d.causes) text += c.effect.type + ' ';
  return text;
}

TEST(Sanity, UndoesASpecifiedRolloverSilently) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path);
    const double modulus = narrow(counts);
    const Log log = log_of(m, wrapped(counts, modulus));
    const Sanity s = check_sanity(model_of(m), {}, log, {effect_of("rollover", "modulus", modulus)});
    EXPECT_TRUE(s.causes.empty()) << "seed " << seed;
    EXPECT_TRUE(s.present.empty()) << "its action must not be on the path a second time";
    EXPECT_TRUE((s.log.values.col(1) == counts).all()) << "seed " << seed;
  }
}

TEST(Sanity, ReportsAModulusOtherThanTheSpecs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Machine m(seed);
    const Column counts = m.counted(m.path);
    const double modulus = narrow(counts);
    if ((wrapped(counts, modulus) == counts).all()) continue;
    for (const double stated : {0.25 * modulus, 0.5 * modulus, 2 * modulus, 65536 * modulus}) {
      const Sanity s = check_sanity(model_of(m), {}, log_of(m, wrapped(counts, modulus)),
                                    {effect_of("rollover", "modulus", stated)});
      ASSERT_EQ(s.causes.size(), 1u) << "seed " << seed << ", stated " << stated << " for " << modulus;
      EXPECT_EQ(s.causes[0].effect.number("modulus"), modulus) << "seed " << seed;
    }
  }
}

TEST(Sanity, ReadsCountsWithTheSpecifiedDecoding) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Machine m(seed);
    const double factor = std::array<double, 7>{0.25, 0.5, 2, 4, -1, -0.5, -0.25}[seed % 7];
    const Log log = log_of(m, (factor * m.counted(m.path) + 0.5).floor());
    const Sanity s = check_sanity(model_of(m), {}, log, {effect_of("decoding", "factor", factor)});
    EXPECT_TRUE(s.causes.empty()) << "seed " << seed;
    const double step = s.model.transmission.encoders[0].resolution;
    EXPECT_NEAR(step, m.resolution * std::max(1.0, 1 / std::abs(factor)), 1e-12);
    EXPECT_LT((s.log.values.col(1) * step - m.path).abs().maxCoeff(), 0.5001 * step) << "seed " << seed;
  }
}

TEST(Diagnosis, TakesStatedLossesInTheCountsOfTheSpec) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Machine m(seed);
    const double time = m.time[m.rows / 2] - 1e-6, factor = seed % 2 == 0 ? 0.5 : 0.25;
    const Column counts = m.counted(m.path) + 16 * (m.time > time).cast<double>();
    Effect missed = effect_of("missed_counts", "counts", 16);
    missed.numbers["time"] = time;
    const Diagnosis d = diagnose(model_of(m), {}, {missed, effect_of("decoding", "factor", factor)},
                                 log_of(m, (factor * counts + 0.5).floor()));
    EXPECT_EQ(d.verdict, Verdict::nothing_wrong) << "seed " << seed << ": " << causes(d);
  }
}

TEST(Sanity, ReportsADecodingOtherThanTheSpecs) {
  Machine m(3);
  const Log log = log_of(m, m.counted(m.path));  // the driver has been mended since
  const Sanity s = check_sanity(model_of(m), {}, log, {effect_of("decoding", "factor", 0.25)});
  ASSERT_EQ(s.causes.size(), 1u);
  EXPECT_EQ(s.causes[0].effect.number("factor"), 4);
  EXPECT_NEAR(s.model.transmission.encoders[0].resolution, m.resolution, 1e-12);
}

TEST(Diagnosis, ReportsNoOffsetForAnyEdgeOfACounterAtX1) {
  for (const double edge : {0.0, 1.0, 2.0, 3.0}) {
    Machine m(5);
    const Log log = log_of(m, ((m.counted(m.path) + edge) / 4).floor());
    const Diagnosis found = diagnose(model_of(m), {}, {}, log);
    EXPECT_EQ(found.verdict, Verdict::explained) << causes(found);
    EXPECT_EQ(causes(found), "decoding ");
    const Diagnosis later = diagnose(model_of(m), {}, {found.causes[0].effect}, log);
    EXPECT_EQ(later.verdict, Verdict::nothing_wrong) << causes(later);
  }
}

TEST(Diagnosis, FindsOnlyTheLogResolutionAndNothingIfItIsSpecified) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(seed);
    const double decade = std::ceil(-std::log10(m.resolution)) - 1, grid = std::pow(10, -decade);
    if (grid < 1.05 * m.resolution) continue;
    const Log log = log_of({{LogSignal::time, m.time},
                            {LogSignal::measured, m.counted(m.path) * m.resolution, static_cast<int>(decade)},
                            {LogSignal::reference, m.reference()}});
    const Diagnosis found = diagnose(model_of(m), {}, {}, log);
    EXPECT_EQ(causes(found), "log_rounding ") << "seed " << seed << ", " << grid / m.resolution << " counts";
    const Diagnosis later = diagnose(model_of(m), {}, {effect_of("log_rounding", "step", grid)}, log);
    EXPECT_EQ(later.verdict, Verdict::nothing_wrong) << "seed " << seed << ": " << causes(later);
    const Sanity other = check_sanity(model_of(m), {}, log, {effect_of("log_rounding", "step", 0.1 * grid)});
    EXPECT_EQ(other.causes.size(), 1u) << "a coarser grid than the spec's is named";
  }
}

TEST(Diagnosis, AcceptsASpecifiedTruncation) {
  Machine m(7);
  const Log log = log_of(m, (m.path / m.resolution).floor());
  const Effect truncation{"truncation", "arm", {}, {}};
  EXPECT_EQ(causes(diagnose(model_of(m), {}, {}, log)), "offset ");
  EXPECT_EQ(diagnose(model_of(m), {}, {truncation}, log).verdict, Verdict::nothing_wrong);
}

TEST(Sanity, AcceptsTheVelocityIfTheFoundFilterIsSpecified) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Machine m(seed);
    const int order = 1 + static_cast<int>(seed % 3);
    const double stated = m.rate / 20, real = stated * std::array<double, 3>{0.3, 0.5, 3}[seed % 3];
    const auto found = [&](const std::vector<Filter>& filters, Machine machine) {
      const Column counts = machine.counted(machine.path);
      const Column velocity = controller_velocity(machine, counts * machine.resolution, order, real);
      return check_sanity(model_of(machine), filters,
                          log_of({{LogSignal::time, machine.time, 7},
                                  {LogSignal::counts, counts, 0},
                                  {LogSignal::reference, machine.reference()},
                                  {LogSignal::velocity, velocity, 7}}))
          .causes;
    };
    const auto first = found({first_order(m.rate, order, stated)}, m);
    ASSERT_EQ(first.size(), 1u) << "seed " << seed;
    ASSERT_EQ(first[0].parameters.size(), 2u);
    const FoundParameter& cutoff = first[0].parameters[1];
    EXPECT_LT(cutoff.lower, cutoff.value);
    EXPECT_NEAR(cutoff.value / real, 1, 1e-4) << "seed " << seed;
    Machine again = m;
    again.sines[0].second[1] += 1;
    again.sines[1].second[0] *= 1.3;
    again.path = again.along(again.time);
    EXPECT_TRUE(
        found({first_order(m.rate, order, stated), first_order(m.rate, order, cutoff.value)}, again).empty())
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace qerr
