#include "input/spec_variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

const std::string file = QERR_SOURCE_DIR "/tests/corpus/variants.yaml";

std::string text(const std::string& more = "") {
  return "qerr: 1\nrobot: {urdf: arm.urdf}\n"
         "encoders: {'*': {counts_per_rev: 4096, gear_ratio: 10}, lift: {resolution: 10 um}}\n"
         "coordinates: [x, z]\n"
         "filters: {velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 1, "
         "cutoff: "
         "50 Hz}}}\n"
         "configurations: {count: 40, limits: {wrist: [-180 deg, 180 deg]}}\n"
         "requirements: [{quantity: position.xyz.sigma, statistic: max, at_most: 1 mm}]\n"
         "effects: [{type: backlash, joint: elbow, gap: 1 mrad}]\n"
         "control: {joints: {elbow: {kp: 100, kd: 1, velocity: velocity, inertia: 0.1, damping: 0.1}}}\n" +
         more;
}

using Set = std::vector<std::pair<std::string, std::string>>;

/// The whole report, which has every figure, warning and requirement of the spec.
std::string report(const Spec& spec) { return write(analyze(spec), "json"); }

std::string report_of_whole(const Set& base, const Set& changes) {
  SpecOverrides all{base, {}};
  all.values.insert(all.values.end(), changes.begin(), changes.end());
  return report(parse_spec(text(), file, all));
}

class Variants : public ::testing::TestWithParam<Set> {};

TEST_P(Variants, EqualSpecsThatAreReadWhole) {
  for (const Set& base : {Set{}, Set{{"encoders.elbow.gear_ratio", "50"}, {"coordinates", "[y]"}}}) {
    const SpecVariants variants(text(), file, {base, {}});
    EXPECT_EQ(report(variants.variant(spec_changes(GetParam()))), report_of_whole(base, GetParam()));
  }
}

INSTANTIATE_TEST_SUITE_P(
    SpecVariants, Variants,
    ::testing::Values(
        Set{}, Set{{"encoders.elbow.counts_per_rev", "8192"}}, Set{{"encoders.*.gear_ratio", "-20"}},
        Set{{"encoders.wrist", "{bits: 17, accuracy: 20 arcsec}"}, {"encoders.*.counts_per_rev", "1000"}},
        Set{{"filters.velocity.lowpass.cutoff", "20 Hz"}}, Set{{"filters.velocity.sample_rate", "2 kHz"}},
        Set{{"frame", "tip"}}, Set{{"coordinates", "[rx]"}},
        Set{{"requirements", "[{quantity: velocity.rxyz.sigma, statistic: p99, at_most: 1 rad/s}]"}},
        Set{{"effects[0].gap", "2 mrad"}}, Set{{"effects", "[]"}},
        Set{{"effects", "[{type: scale, joint: elbow, scale: 0.1}]"}}, Set{{"control.delay", "2 ms"}},
        Set{{"configurations.count", "17"}, {"configurations.seed", "5"}},
        Set{{"robot.tool", "{xyz: [0, 0, 100 mm]}"}},
        Set{{"motion", "{sample_rate: 1 kHz, duration: 1 s, joints: {elbow: {velocity: 0.1 rad/s}}}"}},
        Set{{"encoders.*.counts_per_rev", "64"}, {"robot.tip", "hand"}}));

TEST(SpecVariants, KeepTheSeedOfTheCommandLineAndItsOrder) {
  const SpecVariants variants(text(), file, {{}, 9});
  EXPECT_EQ(variants.variant(spec_changes({{"configurations.count", "3"}})).configurations.seed, 9u);
  EXPECT_EQ(variants.base().configurations.seed, 9u);
}

TEST(SpecVariants, AChangeBehindThatOfItsWholeMappingRefinesIt) {
  struct Refined {
    std::string map, before, key, value, after;
  };
  for (const Refined& r :
       {Refined{"configurations", "{method: random, count: 10, limits: {wrist: [-1, 1]}}", "count", "20",
                "{method: random, count: 20, limits: {wrist: [-1, 1]}}"},
        {"configurations", "{method: random, count: 10, limits: {wrist: [-1, 1]}}", "seed", "7",
         "{method: random, count: 10, seed: 7, limits: {wrist: [-1, 1]}}"},
        {"filters", "{velocity: {derivative: 1, sample_rate: 1 kHz}}", "velocity.sample_rate", "2 kHz",
         "{velocity: {derivative: 1, sample_rate: 2 kHz}}"},
        {"encoders", "{'*': {bits: 12}, lift: {resolution: 1 mm}}", "elbow.bits", "9",
         "{'*': {bits: 12}, elbow: {bits: 9}, lift: {resolution: 1 mm}}"}}) {
    const Set both{{r.map, r.before}, {r.map + '.' + r.key, r.value}};
    const auto figures = [](Spec spec) {
      spec.overrides.clear();
      spec.requirements.clear();
      return report(spec);
    };
    const std::string expected = figures(parse_spec(text(), file, {{{r.map, r.after}}, {}}));
    EXPECT_EQ(figures(parse_spec(text(), file, {both, {}})), expected) << r.key;
    const SpecVariants variants(text(), file, {{both[0]}, {}});
    EXPECT_EQ(figures(variants.variant(spec_changes({both[1]}))), expected) << "a sweep of " << r.key;
  }
  const std::string design = "{minimize: resolution, encoders: {elbow: {bits: 10..12}}}";
  EXPECT_THROW(parse_spec(text(), file, {{{"design", design}, {"design.nonsense", "1"}}, {}}), Error);
}

TEST(SpecVariants, AnEffectTakesThePlaceOfOneOfItsKindOnItsJoint) {
  const SpecVariants variants(text(), file);
  const auto with = [&](const std::string& effect) {
    return variants.variant({}, {spec_change("effects", effect, "test").second}).effects;
  };
  const auto same = with("{type: backlash, joint: elbow, gap: 3 mrad}");
  ASSERT_EQ(same.size(), 1u);
  EXPECT_DOUBLE_EQ(same[0].number("gap"), 3e-3);
  const auto other = with("{type: backlash, joint: shoulder, gap: 3 mrad}");
  ASSERT_EQ(other.size(), 2u);
  EXPECT_EQ(other[1].joint, "shoulder");
}

TEST(SpecVariants, TellThePlaceOfAChangeThatCannotBe) {
  const SpecVariants variants(text("sweep: [{key: encoders.elbow.gear_ratio, values: [1, 2]}]\n"), file);
  EXPECT_TRUE(variants.variant({}).sweep.empty());
  for (const Set& wrong :
       {Set{{"encoders.elbow.bits", "99"}}, Set{{"filters.velocity.lowpass.cutoff", "600 Hz"}},
        Set{{"encoders.nobody.bits", "12"}}}) {
    try {
      variants.variant(spec_changes(wrong));
      ADD_FAILURE() << wrong[0].first;
    } catch (const Error& e) {
      EXPECT_EQ(e.faults().front().place.file, "--set " + wrong[0].first);
    }
  }
  EXPECT_NO_THROW(variants.variant({})) << "a failed variant changes nothing";
}

}  // namespace
}  // namespace qerr
