#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/text.hpp"
#include "input/spec_variants.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/design_report.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

class DesignOfSpec : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_design_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "arm.urdf")
        << R"(<robot name="arm"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
      <joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
      <joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <joint name="j3" type="revolute"><parent link="c"/><child link="d"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
    std::ofstream(folder_ / "side.csv") << "name,price,bits,counts_per_rev,gear_ratio,backlash [arcmin]\n"
                                           "motor,40,,4096,100,3\n"
                                           "motor preloaded,290,,4096,100,0.5\n"
                                           "joint 14,60,14,,,\n"
                                           "joint 17,150,17,,,\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  SpecVariants variants(const std::string& requirements, const std::string& design) {
    const std::string text =
        "qerr: 1\nrobot: {urdf: arm.urdf, tool: {xyz: [0.4, 0.05, 0]}}\nencoders: {'*': {bits: 12}}\n"
        "configurations: {method: random, count: 300}\n"
        "filters: {velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, "
        "cutoff: "
        "50 Hz}}}\nrequirements: [" +
        requirements + "]\ndesign: {" + design + "}\n";
    return SpecVariants(text, (folder_ / "spec.yaml").string());
  }

  DesignReport report(const std::string& requirements, const std::string& design_text) {
    DesignOptions options;
    options.target = (folder_ / "chosen.yaml").string();
    return design(variants(requirements, design_text), options);
  }

  std::filesystem::path folder_;
};

/// The written spec has the figures of the report, and all of them met.
void expect_written_spec_to_pass(const DesignReport& report, const std::filesystem::path& folder) {
  const SpecCheck check = qerr::check(parse_spec(report.written, (folder / "chosen.yaml").string()));
  ASSERT_EQ(check.results.size(), report.optimal->results.size());
  EXPECT_TRUE(check.all_met());
  for (std::size_t i = 0; i < check.results.size(); ++i)
    EXPECT_EQ(check.results[i].value, report.optimal->results[i].value);
}

TEST_F(DesignOfSpec, MotorAndJointSideAreOneCatalogue) {
  for (const double limit : {1.2, 0.6, 0.3, 0.15}) {
    const DesignReport r = report(
        "{quantity: position.xyz.worst_case, statistic: max, at_most: " + std::to_string(limit) + " mm}",
        "encoders: {'*': {catalogue: side.csv}}");
    if (!r.optimal) continue;
    expect_written_spec_to_pass(r, folder_);
    // Every cheaper choice, by analysis of the spec that it makes, fails.
    const double options[] = {40, 290, 60, 150};
    const char* const entries[] = {"{counts_per_rev: 4096, gear_ratio: 100}",
                                   "{counts_per_rev: 4096, gear_ratio: 100}", "{bits: 14}", "{bits: 17}"};
    const double gaps[] = {3, 0.5, 0, 0};
    for (int c = 0; c < 64; ++c) {
      const int o[] = {c % 4, c / 4 % 4, c / 16};
      if (options[o[0]] + options[o[1]] + options[o[2]] >= r.optimal->price) continue;
      SpecOverrides changes;
      std::string effects;
      for (int j = 0; j < 3; ++j) {
        changes.values.emplace_back("encoders.j" + std::to_string(j + 1), entries[o[j]]);
        if (gaps[o[j]] > 0)
          effects += std::string(effects.empty() ? "" : ", ") + "{type: backlash, joint: j" +
                     std::to_string(j + 1) + ", gap: " + std::to_string(gaps[o[j]]) + " arcmin}";
      }
      changes.values.emplace_back("effects", "[" + effects + "]");
      const Spec base =
          variants("{quantity: position.xyz.worst_case, statistic: max, at_most: " + std::to_string(limit) +
                       " mm}",
                   "encoders: {'*': {bits: [12]}}")
              .base();
      EXPECT_FALSE(check(parse_spec(base.text, base.file, changes)).all_met()) << c << " at " << limit;
    }
  }
}

TEST_F(DesignOfSpec, TheCoarsestResolutionHasTheFewestBits) {
  const DesignReport r = report("{quantity: position.x.sigma, statistic: p95, at_most: 50 um}",
                                "minimize: resolution, encoders: {'*': {bits: 8..20}}");
  ASSERT_TRUE(r.optimal && r.runner_up);
  EXPECT_LE(r.optimal->bits, r.runner_up->bits + 1e-9);
  expect_written_spec_to_pass(r, folder_);
}

TEST_F(DesignOfSpec, ALeastFigureOfABudgetIsNotBeatenByTheFront) {
  const DesignReport r = report("{quantity: position.z.worst_case, statistic: max, at_most: 5 mm}",
                                "minimize: position.x.sigma, budget: 45, encoders: {'*': {bits: 8..20}}");
  ASSERT_TRUE(r.optimal && r.runner_up && r.proven);
  EXPECT_LE(r.optimal->price, 45);
  EXPECT_LE(*r.optimal->minimized, *r.runner_up->minimized);
  ASSERT_GT(r.pareto.size(), 3u);
  for (const ParetoPoint& p : r.pareto)
    EXPECT_TRUE(p.price > 45 || p.value >= *r.optimal->minimized * (1 - 1e-9));
  for (std::size_t i = 1; i < r.pareto.size(); ++i) {
    EXPECT_LT(r.pareto[i - 1].price, r.pareto[i].price);
    EXPECT_GT(r.pareto[i - 1].value, r.pareto[i].value);
  }
}

TEST_F(DesignOfSpec, FiltersAndEncodersAreChosenTogether) {
  const std::string limits =
      "{quantity: velocity.x.sigma, statistic: max, at_most: 2 mm/s}, {quantity: velocity.x.worst_case, "
      "statistic: "
      "max, at_most: 40 mm/s}, {quantity: velocity.delay, at_most: 8 ms}";
  const std::string filters = "filters: {velocity: {families: [first_order, butterworth], orders: 1..2}}";
  const DesignReport r = report(limits, "encoders: {'*': {bits: 10..23}}, " + filters);
  ASSERT_TRUE(r.optimal);
  expect_written_spec_to_pass(r, folder_);
  EXPECT_LE(r.optimal->filters.at(0).delay, 8e-3);
  // With a shorter delay the filter is noisier and the encoders are not cheaper.
  const DesignReport hasty = report(limits + ", {quantity: velocity.delay, at_most: 2 ms}",
                                    "encoders: {'*': {bits: 10..23}}, " + filters);
  ASSERT_TRUE(hasty.optimal);
  EXPECT_GT(hasty.optimal->filters.at(0).filter.norms.h2, r.optimal->filters.at(0).filter.norms.h2);
  EXPECT_GE(hasty.optimal->price, r.optimal->price);
}

TEST_F(DesignOfSpec, ALooserLimitIsNotDearer) {
  const DesignReport r = report(
      "{quantity: position.x.sigma, statistic: p95, at_most: 50 um}, {quantity: position.z.sigma, statistic: "
      "mean, "
      "at_most: 40 um}",
      "encoders: {'*': {bits: 8..20}}");
  ASSERT_EQ(r.requirement_prices.size(), 2u);
  for (const RequirementPrice& p : r.requirement_prices) EXPECT_LE(*p.price, r.optimal->price);
}

TEST_F(DesignOfSpec, ALimitThatEqualsAValueIsMet) {
  for (const char* quantity :
       {"position.x.worst_case, statistic: max", "velocity.z.sigma, statistic: p95",
        "position.y.sigma, statistic: mean", "position.xyz.worst_case, statistic: max"}) {
    const std::string begin = std::string("{quantity: ") + quantity + ", at_most: ";
    const std::string options = "encoders: {'*': {bits: 10..16}}";
    const DesignReport loose = report(begin + "0.02}", options);
    ASSERT_TRUE(loose.optimal) << quantity;
    const double value = loose.optimal->results[0].value;
    const auto with_limit = [&](double limit) { return report(begin + shortest(limit) + "}", options); };
    const DesignReport equal = with_limit(value);
    ASSERT_TRUE(equal.optimal) << quantity;
    EXPECT_EQ(equal.optimal->results[0].value, value);
    EXPECT_TRUE(equal.optimal->results[0].met);
    EXPECT_EQ(equal.optimal->price, loose.optimal->price);
    const DesignReport below = with_limit(std::nextafter(value, 0));
    ASSERT_TRUE(below.optimal);
    EXPECT_LT(below.optimal->results[0].value, value);
  }
}

TEST_F(DesignOfSpec, OfOnePriceTheBestMarginStandsAndNotTheFirstRow) {
  std::ofstream(folder_ / "ties.csv")
      << "name,price,bits\ncoarse,10,11\nfine,10,16\nfiner,10,17\ndear,20,20\n";
  const DesignReport r = report("{quantity: position.y.worst_case, statistic: max, at_most: 9 mm}",
                                "encoders: {'*': {catalogue: ties.csv}}");
  ASSERT_TRUE(r.optimal && r.runner_up);
  EXPECT_EQ(r.optimal->price, 30);
  for (const DesignedEncoder& e : r.optimal->encoders) EXPECT_EQ(e.name, "finer") << e.joint;
  EXPECT_EQ(r.runner_up->price, 30);
  EXPECT_GE(r.runner_up->results[0].value, r.optimal->results[0].value);
  ASSERT_FALSE(r.pareto.empty());
  EXPECT_EQ(r.pareto.front().value, r.optimal->results[0].value);
}

TEST_F(DesignOfSpec, TheSecondRequirementDecidesWhereTheWorstMarginDoesNot) {
  // The last joint does not move the tip along its own axis' direction: only rx hears it.
  std::ofstream(folder_ / "ties.csv") << "name,price,bits\ncoarse,10,11\nfine,10,16\n";
  const DesignReport r = report(
      "{quantity: position.z.worst_case, statistic: max, at_most: 3 mm}, {quantity: "
      "position.y.worst_case, statistic: max, at_most: 90 mm}",
      "encoders: {j1: {catalogue: ties.csv}}");
  ASSERT_TRUE(r.optimal);
  EXPECT_EQ(r.optimal->encoders[0].name, "fine");
}

TEST_F(DesignOfSpec, WhatHindersIsTheLeastOfEachRequirementAndNotTheMostBits) {
  std::ofstream(folder_ / "play.csv") << "name,price,bits,backlash [arcmin]\nworn,10,20,10\nnew,20,14,\n";
  const DesignReport r = report("{quantity: position.y.worst_case, statistic: max, at_most: 1 um}",
                                "encoders: {'*': {catalogue: play.csv}}");
  ASSERT_TRUE(!r.optimal && r.finest);
  for (const DesignedEncoder& e : r.finest->encoders) EXPECT_EQ(e.name, "new");
  ASSERT_EQ(r.obstacles.size(), 1u);
  EXPECT_NE(r.obstacles[0].find("at least whatever is chosen"), std::string::npos) << r.obstacles[0];
}

TEST_F(DesignOfSpec, AnEncoderThatCannotCountIsNoChoice) {
  // At 1 rad/s 16 bits count 10430 times a second, 14 bits 2608 times.
  std::ofstream(folder_ / "slow.csv")
      << "name,price,bits,max_count_rate\nfast,30,14,3 kHz\nslow,10,16,10 kHz\n";
  const std::string limit = "{quantity: position.y.worst_case, statistic: max, at_most: 90 mm}";
  const DesignReport r = report(limit, "encoders: {'*': {catalogue: slow.csv}}");
  ASSERT_TRUE(r.optimal);
  for (const DesignedEncoder& e : r.optimal->encoders) EXPECT_EQ(e.name, "fast");
  EXPECT_EQ(r.left_out.size(), 3u);
  // 12 bits of a counter hold 2048 counts of the 2608 in a sample at 1 kHz: it is the filters' rate that
  // counts.
  const DesignReport none = report(limit, "encoders: {'*': {bits: [16], max_frequency: [1 kHz]}}");
  ASSERT_FALSE(none.optimal);
  ASSERT_EQ(none.obstacles.size(), 3u);
  EXPECT_NE(none.obstacles[0].find("'j1': none of 1 option"), std::string::npos) << none.obstacles[0];
  const DesignReport required = report(limit + ", {quantity: encoder.j2.count_rate, at_most: 3 kHz}",
                                       "encoders: {'*': {bits: [14, 16]}}");
  ASSERT_TRUE(required.optimal);
  EXPECT_EQ(required.optimal->encoders[1].name, "bits 14");
  expect_written_spec_to_pass(required, folder_);
}

TEST_F(DesignOfSpec, AnOverrideOfALowPassThatDesignChoosesIsRefused) {
  const Spec spec =
      variants("{quantity: velocity.delay, at_most: 1 s}", "filters: {velocity: {cutoff: [5 Hz, 50 Hz]}}")
          .base();
  const auto refused = [&](const std::string& key, const std::string& value) {
    const SpecOverrides set{{{key, value}}, {}};
    try {
      refuse_chosen(parse_spec(spec.text, spec.file, set), set);
    } catch (const Error& e) {
      return std::string(e.what()).find("design.filters") != std::string::npos;
    }
    return false;
  };
  for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
           {"filters.velocity.lowpass.cutoff", "20 Hz"},
           {"filters.velocity.lowpass.order", "3"},
           {"filters.velocity.lowpass", "{family: butterworth, order: 2, cutoff: 20 Hz}"},
           {"filters.velocity", "{derivative: 1, sample_rate: 1 kHz}"}})
    EXPECT_TRUE(refused(key, value)) << key;
  for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
           {"filters.velocity.lowpass.cutoff", "50 Hz"},  // the value that holds
           {"filters.velocity.sample_rate", "2 kHz"},
           {"filters.velocity.derivative", "2"},
           {"encoders.*.bits", "13"}})
    EXPECT_FALSE(refused(key, value)) << key;
}

TEST_F(DesignOfSpec, RowsWithoutAPriceAreChoicesUnlessAPriceIsMinimized) {
  std::ofstream(folder_ / "unpriced.csv") << "name,price,bits\na,,12\nb,40,14\nc,,17\n";
  const std::string limit = "{quantity: position.y.worst_case, statistic: max, at_most: 2 mm}";
  const std::string encoders = "encoders: {'*': {catalogue: unpriced.csv}}";
  const DesignReport coarsest = report(limit, "minimize: resolution, " + encoders);
  ASSERT_TRUE(coarsest.optimal);
  const DesignReport finest = report(limit, "minimize: position.y.worst_case, " + encoders);
  ASSERT_TRUE(finest.optimal);
  EXPECT_TRUE(finest.by_bits);
  EXPECT_FALSE(finest.optimal->price);
  for (const DesignedEncoder& e : finest.optimal->encoders) EXPECT_EQ(e.name, "c") << e.joint;
  EXPECT_THROW(report(limit, encoders), Error);
}

TEST_F(DesignOfSpec, AccuracyAndPlayBehindAVelocityFilterHaveAnAnswer) {
  std::ofstream(folder_ / "gears.csv")
      << "name,price,bits,accuracy,backlash [arcmin]\nworn,10,14,0.1 deg,20\n"
         "new,20,14,0.1 deg,\nfine,30,14,,\n";
  const std::string encoders = "encoders: {'*': {catalogue: gears.csv}}";
  for (const char* limit : {"8 mm/s", "1.7 mm/s"}) {
    const DesignReport r =
        report(std::string("{quantity: velocity.y.sigma, statistic: max, at_most: ") + limit + "}", encoders);
    if (r.optimal) expect_written_spec_to_pass(r, folder_);
    EXPECT_TRUE(r.optimal || r.finest);
  }
}

TEST_F(DesignOfSpec, TheWrittenSpecLosesTheCommentsOfWhatIsReplaced) {
  const SpecVariants commented(
      "qerr: 1\nrobot: {urdf: arm.urdf}\nencoders:\n  # the old one, 12 bits\n  j1: {bits: 12}  # AS5600\n"
      "  j2:  # as bought\n    bits: 13  # of a turn\n  # kept\n  j3: {bits: 14}  # stays\n"
      "requirements: [{quantity: position.y.worst_case, statistic: max, at_most: 9 mm}]  # of the task\n"
      "design: {encoders: {j1: {bits: [15]}, j2: {bits: [16]}}}\n",
      (folder_ / "spec.yaml").string());
  DesignOptions options;
  options.target = (folder_ / "chosen.yaml").string();
  const std::string text = design(commented, options).written;
  for (const char* gone : {"old one", "AS5600", "of a turn", "as bought"})
    EXPECT_EQ(text.find(gone), std::string::npos) << gone << '\n' << text;
  for (const char* kept : {"# kept", "# stays", "# of the task"})
    EXPECT_NE(text.find(kept), std::string::npos) << kept << '\n' << text;
}

}  // namespace
}  // namespace qerr
