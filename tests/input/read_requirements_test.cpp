#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "qerr/filter/norms.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

class Requirements : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_requirements_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "arm.urdf")
        << R"(<robot name="arm"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
      <joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Spec read(const std::string& requirement) {
    std::ofstream(folder_ / "spec.yaml")
        << "qerr: 1\nrobot: {urdf: arm.urdf, tool: {xyz: [0.4, 0, 0]}}\nencoders: {'*': {resolution: 1 "
           "mrad}}\n"
           "configurations: {method: random, count: 500}\n"
           "filters: {v.x: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: butterworth, order: 2, "
           "cutoff: 30 Hz}}}\n"
        << (requirement.empty() ? "" : "requirements:\n  - " + requirement + "\n");
    return read_spec((folder_ / "spec.yaml").string());
  }

  std::string refusal(const std::string& requirement) {
    try {
      check(read(requirement));
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }

  RequirementResult result(const std::string& requirement) {
    return check(read(requirement)).results.front();
  }

  std::filesystem::path folder_;
};

TEST_F(Requirements, AtLeastIsMetFromTheLimitUpwards) {
  const double least = result("{quantity: position.x.sigma, statistic: min, at_least: 0}").value;
  const std::string of = "{quantity: position.x.sigma, statistic: min, at_least: ";
  EXPECT_TRUE(result(of + std::to_string(0.9 * least * 1e6) + " um}").met);
  EXPECT_FALSE(result(of + std::to_string(1.1 * least * 1e6) + " um}").met);
}

TEST_F(Requirements, OfAFilterAreItsFigures) {
  const Spec spec = read("");
  const Filter& filter = spec.filters.front().filter;
  const auto value = [&](const std::string& figure, const std::string& limit) {
    return result("{quantity: v.x." + figure + ", at_most: " + limit + "}").value;
  };
  EXPECT_EQ(value("h2_norm", "1"), spec.filters.front().norms.h2);
  EXPECT_EQ(value("l1_norm", "1"), spec.filters.front().norms.l1.upper);
  EXPECT_EQ(value("delay", "3 ms"), group_delay(filter));
  EXPECT_EQ(value("bandwidth", "3 Hz"), *bandwidth(filter));
  EXPECT_EQ(value("settling", "0.1 s"), *settling_time(filter));
  EXPECT_TRUE(result("{quantity: v.x.delay, at_most: 1 s}").met);
  EXPECT_FALSE(result("{quantity: v.x.delay, at_most: 1 us}").met);
  EXPECT_TRUE(result("{quantity: v.x.bandwidth, at_least: 1 Hz}").met);
}

TEST_F(Requirements, MedianAndOldNamesAreAliases) {
  const double p50 = result("{quantity: position.z.worst_case, statistic: p50, at_most: 1}").value;
  EXPECT_EQ(result("{quantity: position.z.worst_case, statistic: median, at_most: 1}").value, p50);
  EXPECT_EQ(result("{quantity: z.worst_case, statistic: median, at_most: 1}").value, p50);
}

TEST_F(Requirements, LengthsNeedNotBeListed) {
  const Spec spec = read("{quantity: position.xyz.worst_case, statistic: max, at_most: 1 m}");
  EXPECT_EQ(spec.model.lengths, std::vector<Coordinate>{Coordinate::xyz});
  const SpecCheck report = check(spec);
  // Both joints err by half a count; their columns are orthogonal: the corner is the diagonal.
  const double q2 = report.results.front().at_max[1];
  const double first = 0.5 + 0.4 * std::cos(q2), second = 0.4;
  EXPECT_NEAR(report.results.front().value, 0.5e-3 * std::hypot(first, second), 1e-12);
}

TEST_F(Requirements, KnowWhereTheQuantityIsLargest) {
  const RequirementResult r = result("{quantity: position.xyz.sigma, statistic: p95, at_most: 1 um}");
  EXPECT_FALSE(r.met);
  EXPECT_EQ(r.at_max.size(), 2);
  EXPECT_EQ(result("{quantity: v.x.delay, at_most: 1 us}").at_max.size(), 0);
}

TEST_F(Requirements, SayWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "there is nothing to check"},
      {"{quantity: position.x.sigma, at_most: 1}", "missing key 'statistic'"},
      {"{quantity: v.x.delay, statistic: max, at_most: 1}", "has no statistic"},
      {"{quantity: position.x.sigma, statistic: max}", "has no limit"},
      {"{quantity: position.x.sigma, statistic: max, at_most: 1 mm, at_least: 1 mm}", "has two limits"},
      {"{quantity: position.x.sigma, statistic: max, at_most: 1 Hz}", "found '1 Hz'"},
      {"{quantity: v.x.delay, at_most: 1 mm}", "found '1 mm'"},
      {"{quantity: position.rx.sigma, statistic: max, at_most: 1 mrad}", "add it to 'coordinates'"},
      {"{quantity: velocity.x.sigma, statistic: max, at_most: 1 mm}", "no such filter 'velocity'"},
      {"{quantity: torque.elbow.sigma, statistic: max, at_most: 1}", "the spec has no controllers"},
      {"{quantity: v.x.dela, at_most: 1 ms}", "did you mean 'delay'"},
      {"{quantity: sigma, statistic: max, at_most: 1 mm}", "write position.x.worst_case"}};
  for (const auto& [requirement, words] : cases)
    EXPECT_NE(refusal(requirement).find(words), std::string::npos) << requirement << '\n'
                                                                   << refusal(requirement);
}

CheckReport report_of(const Spec& spec) {
  CheckReport report;
  report.specs.push_back(check(spec));
  return report;
}

TEST_F(Requirements, OfWhichOneFailsIsAnnotatedAtItsLine) {
  const CheckReport report =
      report_of(read("{quantity: v.x.delay, at_most: 1 us}\n  - {quantity: v.x.delay, at_most: 1 s}"));
  EXPECT_FALSE(report.all_met());
  const std::string text = github_annotations(report);
  EXPECT_EQ(text.find("::error file=" + (folder_ / "spec.yaml").string() + ",line=7::v.x.delay is "), 0u)
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST_F(Requirements, OfDifferentLimitsHaveDifferentNamesOfTestCases) {
  const std::string text = junit(report_of(read("{quantity: v.x.delay, at_most: 1.0001 ms}\n"
                                                "  - {quantity: v.x.delay, at_most: 1.0002 ms}\n"
                                                "  - {quantity: v.x.delay, at_most: 0.7 ms}")),
                                 "");
  for (const char* name :
       {"v.x.delay &lt;= 1.0001 ms\"", "v.x.delay &lt;= 1.0002 ms\"", "v.x.delay &lt;= 700 us\""})
    EXPECT_NE(text.find(name), std::string::npos) << text;
}

TEST_F(Requirements, AreATableInMarkdownWhoseRowsHaveAsManyCells) {
  CheckReport report =
      report_of(read("{quantity: v.x.delay, at_most: 1 us}\n  - {quantity: v.x.delay, at_most: 1 s}"));
  report.broken.push_back({"a|b`.yaml", Error(Fault{{"a|b`.yaml", 2, 1}, "robto", "unknown key", "", ""})});
  std::istringstream lines(qerr::write(report, "md"));
  int rows = 0;
  for (std::string line; std::getline(lines, line); ++rows) {
    int bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    EXPECT_EQ(bars, 5) << line;
  }
  EXPECT_EQ(rows, 5);
  EXPECT_THROW(qerr::write(report.specs[0].analysis, "md"), Error);
}

TEST_F(Requirements, OfSeveralSpecsAreSuitesOfOneDocument) {
  const Spec spec = read("{quantity: v.x.delay, at_most: 1 us}");
  CheckReport report = report_of(spec);
  report.specs.push_back(check(read("{quantity: v.x.delay, at_most: 1 s}")));
  const std::string text = junit(report, "2026-01-31T12:00:00");
  EXPECT_NE(text.find("<testsuites>"), std::string::npos);
  EXPECT_NE(text.find("id=\"0\""), std::string::npos);
  EXPECT_NE(text.find("id=\"1\""), std::string::npos);
  EXPECT_NE(text.find("failures=\"1\""), std::string::npos);
  EXPECT_NE(text.find("failures=\"0\""), std::string::npos);
  report.specs.front().seconds = 1.25;
  EXPECT_NE(junit(report, "").find("time=\"1.250\""), std::string::npos);
  // Equal requirements are cases of their own, and a broken spec is an error.
  const std::string before = junit(report, "");
  report.specs.push_back(check(spec));
  report.broken.push_back(
      {"broken.yaml", Error(Fault{{"broken.yaml", 2, 1}, "robto", "unknown key", "", ""})});
  const std::string after = junit(report, "");
  EXPECT_EQ(before.find("1.00 us (2)"), std::string::npos);
  EXPECT_NE(after.find("1.00 us (2)"), std::string::npos);
  EXPECT_NE(after.find("<testcase classname=\"broken.yaml\""), std::string::npos);
  EXPECT_NE(after.find("errors=\"1\""), std::string::npos);
  EXPECT_FALSE(report.all_met());
  report.specs.pop_back();
  report.broken.clear();
  EXPECT_NE(qerr::write(report, "json").find("\"reports\""), std::string::npos);
  EXPECT_EQ(qerr::write(report_of(spec), "json").find("\"reports\""), std::string::npos);
}

}  // namespace
}  // namespace qerr
