#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

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

}  // namespace
}  // namespace qerr
