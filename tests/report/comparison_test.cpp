#include "qerr/report/comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/filter_report.hpp"
#include "qerr/report/write.hpp"

namespace qerr {
namespace {

NamedFigures figures(std::vector<NamedFigure> list) {
  NamedFigures f;
  f.file = "r.json";
  f.command = "check";
  f.figures = std::move(list);
  return f;
}

NamedFigure x_sigma(double value) { return {"velocity.x.sigma", "max", "m/s", value}; }

double change_of(double a, double b) {
  // A figure of usual size beside it, so that zero is judged by it.
  const NamedFigure other{"velocity.y.sigma", "max", "m/s", 1e-3};
  const ReportComparison c = compare(figures({x_sigma(a), other}), figures({x_sigma(b), other}));
  for (const FigureChange& f : c.figures)
    if (f.figure.quantity == "velocity.x.sigma") return f.relative;
  return NAN;
}

TEST(ReportComparison, ChangesAreRelativeToTheFirstReport) {
  EXPECT_DOUBLE_EQ(change_of(2e-3, 3e-3), 0.5);
  EXPECT_DOUBLE_EQ(change_of(2e-3, 1e-3), -0.5);
  EXPECT_DOUBLE_EQ(change_of(-2e-3, -1e-3), 0.5) << "a larger one, such as a negative delay";
  EXPECT_EQ(change_of(0, 0), 0);
  EXPECT_EQ(change_of(0, -0.0), 0);
  EXPECT_EQ(change_of(0, 1e-3), INFINITY);
  EXPECT_DOUBLE_EQ(change_of(1e-3, 0), -1);
  EXPECT_EQ(change_of(1e-3, INFINITY), INFINITY);
  EXPECT_EQ(change_of(INFINITY, 1e-3), -1);
  EXPECT_EQ(change_of(INFINITY, INFINITY), 0);
  EXPECT_EQ(change_of(0, INFINITY), INFINITY);
}

TEST(ReportComparison, RoundingIsNoChange) {
  EXPECT_EQ(change_of(1e-3, 1e-3 * (1 + 1e-13)), 0);
  EXPECT_EQ(change_of(0, 1e-20), 0) << "a coordinate that no encoder moves";
  EXPECT_EQ(change_of(3e-20, 1e-20), 0);
  EXPECT_NE(change_of(1e-3, 1e-3 * (1 + 1e-6)), 0);
}

TEST(ReportComparison, RequirementsFlipInTheOrderOfTheirMargins) {
  const auto named = [](const char* quantity, double value) {
    return NamedFigure{quantity, "max", "m", value};
  };
  NamedFigures a = figures({}), b = figures({});
  a.requirements = {{named("wide", 1), false, 10, true},   {named("last", 1), false, 3, true},
                    {named("first", 1), false, 1.5, true}, {named("mended", 4), false, 2, false},
                    {named("narrow", 9), false, 10, true}, {named("least", 9), true, 5, true}};
  b.requirements = {{named("wide", 2), false, 10, true},     {named("last", 5), false, 3, false},
                    {named("first", 6), false, 1.5, false},  {named("mended", 0), false, 2, true},
                    {named("narrow", 9.5), false, 10, true}, {named("least", 6), true, 5, true}};
  const ReportComparison c = compare(a, b);
  std::vector<std::string> order;
  for (const RequirementChange& r : c.requirements) order.push_back(r.any().figure.quantity);
  EXPECT_EQ(order, (std::vector<std::string>{"first", "last", "mended", "narrow", "least", "wide"}));
  EXPECT_DOUBLE_EQ(*c.requirements[0].flips_after(), 0.1);
  EXPECT_DOUBLE_EQ(*c.requirements[1].flips_after(), 0.5);
  EXPECT_DOUBLE_EQ(*c.requirements[2].flips_after(), 0.5);
  EXPECT_FALSE(c.requirements[3].flips_after());
  EXPECT_DOUBLE_EQ(margin(*c.requirements[3].b), 0.05);
  EXPECT_DOUBLE_EQ(margin(*c.requirements[4].b), 0.2);
  EXPECT_LT(margin(*c.requirements[0].b), 0);
  const std::string table = write(c, "table");
  EXPECT_NE(table.find("flips after 10 % of the change"), std::string::npos) << table;
  EXPECT_NE(table.find("next to flip: narrow max, margin 10 % in A, 5 % in B"), std::string::npos) << table;
}

TEST(ReportComparison, AnUnboundedFigureFlipsAtOnce) {
  NamedFigures a = figures({}), b = figures({});
  a.requirements = {{x_sigma(1), false, 2, true}};
  b.requirements = {{x_sigma(INFINITY), false, 2, false}};
  EXPECT_EQ(*compare(a, b).requirements[0].flips_after(), 0);
  EXPECT_EQ(*compare(b, a).requirements[0].flips_after(), 1);
}

TEST(ReportComparison, SortsByWhatAPersonWantsToSeeFirst) {
  NamedFigures a = figures({x_sigma(1), {"velocity.y.sigma", "max", "m/s", 1}, {"only.a", "", "s", 1}});
  NamedFigures b = figures({x_sigma(1.1), {"velocity.y.sigma", "max", "m/s", 0.5}, {"only.b", "", "s", 1}});
  a.shares = {{"j1", 0.5}, {"j2", 0.4}, {"j3", 0.1}};
  b.shares = {{"j1", 0.51}, {"j2", 0.2}, {"j4", 0.29}};
  a.requirements = {{x_sigma(1), false, 2, true}, {{"velocity.y.sigma", "max", "m/s", 1}, false, 0.8, false}};
  b.requirements = {{x_sigma(1.1), false, 2, true},
                    {{"velocity.y.sigma", "max", "m/s", 0.5}, false, 0.8, true}};
  const ReportComparison c = compare(a, b);
  EXPECT_EQ(c.requirements.front().any().figure.quantity, "velocity.y.sigma");
  EXPECT_TRUE(c.requirements.front().flipped());
  EXPECT_FALSE(c.requirements.back().flipped());
  EXPECT_EQ(c.figures[0].figure.quantity, "velocity.y.sigma");
  EXPECT_EQ(c.figures[1].figure.quantity, "velocity.x.sigma");
  EXPECT_FALSE(c.figures[2].b);
  EXPECT_FALSE(c.figures[3].a);
  EXPECT_EQ(c.shares[0].encoder, "j4");
  EXPECT_FALSE(c.shares[0].a);
  EXPECT_EQ(c.shares[1].encoder, "j2");
  const std::string text = write(c, "table");
  std::size_t at = 0;
  for (const char* part : {"1 requirement now met", "velocity.y.sigma max: NOW MET", "A 1.00 m/s > 800 mm/s",
                           "-50 %", "+10 %", "j2", "Only in A\n  only.a", "Only in B\n  only.b"}) {
    const std::size_t found = text.find(part, at);
    ASSERT_NE(found, std::string::npos) << part << "\nin\n" << text;
    at = found;
  }
}

TEST(ReportComparison, ShowsTheMaximumOrWhatChangedInPrint) {
  const auto quantity = [](const char* name, double max, double p50) {
    return std::vector<NamedFigure>{{name, "max", "m", max}, {name, "p50", "m", p50}};
  };
  const auto both = [&](double x_max, double x_p50, double y_max, double y_p50) {
    std::vector<NamedFigure> list = quantity("position.x.sigma", x_max, x_p50);
    for (const NamedFigure& f : quantity("position.y.sigma", y_max, y_p50)) list.push_back(f);
    return figures(list);
  };
  ReportComparison c = compare(both(2, 1, 2, 1), both(3, 1.5, 2.0001, 1.5));
  const std::string text = write(c, "table");
  EXPECT_NE(text.find("position.x.sigma max"), std::string::npos) << text;
  EXPECT_EQ(text.find("position.x.sigma p50"), std::string::npos) << text;
  EXPECT_EQ(text.find("position.y.sigma max"), std::string::npos) << text;
  EXPECT_NE(text.find("position.y.sigma p50"), std::string::npos) << text;
  c.details = true;
  for (const char* name : {"position.x.sigma p50", "position.y.sigma max"})
    EXPECT_NE(write(c, "table").find(name), std::string::npos) << name;
}

TEST(ReportComparison, RefusesUnequalUnitsAndOtherCommands) {
  NamedFigures other = figures({{"velocity.x.sigma", "max", "m/s^2", 1}});
  try {
    compare(figures({x_sigma(1)}), other);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("velocity.x.sigma: a figure must have one unit"), std::string::npos)
        << e.what();
  }
  other.command = "filter";
  EXPECT_THROW(compare(figures({}), other), Error);
}

class SpecReports : public ::testing::Test {
 protected:
  static Spec spec(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
    SpecOverrides overrides;
    overrides.values = {{"configurations.count", "50"}};
    overrides.values.insert(overrides.values.end(), changes.begin(), changes.end());
    return read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml", overrides);
  }
  static std::string check_report(const SpecCheck& check) { return write(CheckReport{{check}}, "json"); }
};

TEST_F(SpecReports, HaveTheFiguresOfTheSpec) {
  const SpecCheck now = evaluate(spec());
  const FilterReport filters = filter_report(now.analysis.spec, {});
  for (const auto& [command, text] :
       {std::pair<std::string, std::string>{"analyze", write(now.analysis, "json")},
        {"check", check_report(now)},
        {"filter", write(filters, "json")}}) {
    const NamedFigures read = read_named_figures(text, "r.json");
    EXPECT_EQ(read.command, command);
    EXPECT_FALSE(read.figures.empty());
    const ReportComparison c = compare(read, named_figures(now, command));
    EXPECT_EQ(c.figures.size(), read.figures.size());
    for (const FigureChange& f : c.figures) {
      EXPECT_TRUE(f.in_both()) << f.figure.name();
      EXPECT_EQ(f.a, f.b) << f.figure.name();
    }
  }
}

/// Every requirement finds its figure, with its value and unit, in the report of analyze or filter.
TEST_F(SpecReports, NameFiguresAsRequirementsDo) {
  const SpecCheck now = evaluate(spec(
      {{"coordinates", "[x, rx, xyz]"},
       {"requirements",
        "[{quantity: x.worst_case, statistic: median, at_most: 1}, {quantity: velocity.rx.sigma, statistic: "
        "p95, at_most: 1}, {quantity: position.xyz.worst_case, statistic: max, at_most: 1}, {quantity: "
        "acceleration.x.worst_case, statistic: min, at_least: 0}, {quantity: velocity.h2_norm, at_most: 1}, "
        "{quantity: velocity.l1_norm, at_most: 1}, {quantity: velocity.delay, at_most: 1}, {quantity: "
        "velocity.bandwidth, at_least: 1}, {quantity: acceleration.settling, at_most: 1}]"}}));
  ASSERT_EQ(now.results.size(), 9u);
  const NamedFigures required = named_figures(now, "check");
  std::vector<NamedFigure> known = named_figures(now, "analyze").figures;
  for (const NamedFigure& f : named_figures(now, "filter").figures) known.push_back(f);
  ASSERT_EQ(required.figures.size(), 9u);
  for (const NamedFigure& r : required.figures) {
    const auto same = std::find_if(known.begin(), known.end(), [&](const NamedFigure& f) {
      return f.quantity == r.quantity && f.statistic == r.statistic;
    });
    ASSERT_NE(same, known.end()) << r.name();
    EXPECT_EQ(same->value, r.value) << r.name();
    EXPECT_EQ(same->unit, r.unit) << r.name();
  }
}

TEST_F(SpecReports, AreRefusedWithPlaceAndRemedy) {
  const std::string good = write(evaluate(spec()).analysis, "json");
  auto with_text = nlohmann::ordered_json::parse(good);
  with_text["position"][0]["worst_case"]["max"] = "inf";
  const auto replaced = [&](const std::string& old, const std::string& with) {
    std::string text = good;
    return text.replace(text.find(old), old.size(), with);
  };
  for (const auto& [text, message] : {
           std::pair<std::string, std::string>{"", "r.json:1:1: the file is empty"},
           {"{\n \"a\": NaN}", "r.json:2:7: the text is no valid JSON; write the file anew"},
           {"{\n \"a\": 1e400}", "r.json:2:7: a number is too large; write the file anew"},
           {"{}", "this is no report of qerr"},
           {"[1]", "this is no report of qerr"},
           {std::string(100000, '['), "64 levels"},
           {replaced("\"analyze\"", "\"simulate\""), "command: only reports of analyze, check and filter"},
           {with_text.dump(), "position[0].worst_case.max: must be a number, found \"inf\""},
           {replaced("\"position\"", "\"positions\""), "missing member 'position'"},
       }) {
    try {
      read_named_figures(text, "r.json");
      ADD_FAILURE() << message;
    } catch (const Error& e) {
      const std::string what = e.what();
      EXPECT_NE(what.find(message), std::string::npos) << what;
      EXPECT_NE(what.find("; write"), std::string::npos) << what;
    }
  }
}

TEST_F(SpecReports, TakeNullForUnboundedAndLeaveOutWhatIsNotKnown) {
  auto json = nlohmann::ordered_json::parse(write(evaluate(spec()).analysis, "json"));
  json["position"][0]["worst_case"]["max"] = nullptr;
  json["position"][0]["worst_case_rigorous"] = nullptr;
  json["derivatives"][0]["l1_norm"]["upper"] = nullptr;
  const NamedFigures read = read_named_figures(json.dump(), "r.json");
  const auto value = [&](const std::string& name) -> std::optional<double> {
    for (const NamedFigure& f : read.figures)
      if (f.name() == name) return f.value;
    return {};
  };
  EXPECT_EQ(value("position.x.worst_case max"), INFINITY);
  EXPECT_EQ(value("position.x.worst_case_rigorous max"), std::nullopt);
  EXPECT_EQ(value("velocity.l1_norm"), INFINITY);
  const ReportComparison c = compare(read, read);
  EXPECT_EQ(c.figures.front().relative, 0);
  EXPECT_NE(write(c, "table").find("all unchanged"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::accept(write(c, "json")));
}

TEST_F(SpecReports, FitEightyColumnsWhateverTheNames) {
  const std::string longest(100, 'n');
  NamedFigures a = figures({{longest + ".x.sigma", "max", "m/s", 1}, {longest + longest, "", "s", 1}}), b = a;
  b.figures[0].value = 1.234e9;
  b.figures[1].quantity = "other" + longest;
  b.file = longest + longest;
  a.shares = {{longest, 0.5}};
  b.shares = {{longest, 0.25}};
  a.requirements = {{a.figures[0], false, 2, true}};
  b.requirements = {{b.figures[0], false, 2, false}};
  std::istringstream lines(write(compare(a, b), "table"));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 80u) << line;
}

SpecCheck checked(const std::string& old, double tolerance, const Spec& now) {
  const Baselines baselines = read_baselines(old, "old.json", tolerance);
  return check(now, {}, &baseline_of(baselines, now.file, true));
}

/// Bounds are proportional to the resolution: 35640 counts in place of 36000 make them worse by 1/99.
const std::vector<std::pair<std::string, std::string>> coarser{{"encoders.*.counts_per_rev", "35640"}};

TEST_F(SpecReports, AreBaselinesOfLaterChecks) {
  const SpecCheck before = evaluate(spec());
  for (const std::string& old : {write(before.analysis, "json"), check_report(before)}) {
    const SpecCheck same = checked(old, 0, spec());
    EXPECT_TRUE(same.all_met());
    EXPECT_GT(same.baseline->compared, 0u);
    EXPECT_TRUE(checked(old, 0.0102, spec(coarser)).all_met());
    const SpecCheck worse = checked(old, 0.01, spec(coarser));
    EXPECT_FALSE(worse.all_met());
    for (const RequirementResult& r : worse.results) EXPECT_TRUE(r.met);
    ASSERT_FALSE(worse.baseline->regressions.empty());
    for (const FigureChange& c : worse.baseline->worst_by_quantity()) EXPECT_GE(c.relative, 0.01);
    const CheckReport report{{worse}};
    const std::string table = write(report, "table"), xml = junit(report, "2026-01-31T12:00:00");
    EXPECT_NE(table.find("worse than in old.json by more than 1 %"), std::string::npos) << table;
    EXPECT_NE(table.find("+1.01 %"), std::string::npos) << table;
    EXPECT_NE(xml.find("tests=\"3\" failures=\"1\""), std::string::npos) << xml;
    EXPECT_NE(xml.find("name=\"baseline old.json\""), std::string::npos) << xml;
    EXPECT_NE(github_annotations(report).find(", worse than in old.json"), std::string::npos);
    const auto json = nlohmann::json::parse(write(report, "json"));
    EXPECT_FALSE(json["met"]);
    EXPECT_EQ(json["regressions"].size(), worse.baseline->regressions.size());
  }
}

TEST_F(SpecReports, AreEnoughToCheckASpecWithoutRequirements) {
  const Spec bare = spec({{"requirements", "[]"}});
  EXPECT_THROW(check(bare), Error);
  const SpecCheck before = evaluate(spec());
  const SpecCheck now = checked(check_report(before), 0, bare);
  EXPECT_TRUE(now.all_met());
  EXPECT_EQ(now.baseline->compared, 2u) << "figures stay comparable";
  ASSERT_EQ(now.baseline->dropped_requirements.size(), 2u);
  EXPECT_NE(write(CheckReport{{now}}, "table").find("the baseline requires position.z.worst_case max"),
            std::string::npos);
}

TEST_F(SpecReports, NameTheFiguresThatTheSpecLacks) {
  const std::string old = write(evaluate(spec()).analysis, "json");
  const SpecCheck now = checked(old, 0, spec({{"filters", "{}"}, {"requirements", "[]"}}));
  EXPECT_TRUE(now.all_met());
  ASSERT_FALSE(now.baseline->missing.empty());
  const std::string table = write(CheckReport{{now}}, "table");
  EXPECT_NE(table.find("the spec lacks"), std::string::npos) << table;
  EXPECT_NE(table.find("velocity"), std::string::npos) << table;
}

TEST_F(SpecReports, CountASmallerFigureAsWorseWhereItIsAtLeastRequired) {
  const auto with_cutoff = [&](const char* cutoff) {
    return spec(
        {{"requirements",
          "[{quantity: velocity.bandwidth, at_least: 1 Hz}, {quantity: velocity.delay, at_most: 1 s}]"},
         {"filters.velocity.lowpass.cutoff", cutoff}});
  };
  const std::string old = check_report(evaluate(with_cutoff("30 Hz")));
  const auto regressed = [&](const char* cutoff) {
    std::vector<std::string> names;
    const SpecCheck now = checked(old, 0.02, with_cutoff(cutoff));
    for (const FigureChange& c : now.baseline->regressions) names.push_back(c.figure.quantity);
    return names;
  };
  EXPECT_EQ(regressed("30 Hz"), std::vector<std::string>());
  EXPECT_EQ(regressed("60 Hz"), std::vector<std::string>()) << "faster: more bandwidth, less delay";
  const std::vector<std::string> slower = regressed("15 Hz");
  EXPECT_EQ(slower.size(), 2u);
}

TEST_F(SpecReports, NameTheRequirementsThatTheBaselineLacks) {
  const std::string old = write(evaluate(spec()).analysis, "json");
  const SpecCheck now = checked(
      old, 0,
      spec({{"requirements", "[{quantity: position.x.worst_case, statistic: proven_max, at_most: 1 m}]"}}));
  ASSERT_EQ(now.baseline->not_in_baseline.size(), 1u);
  const std::string table = write(CheckReport{{now}}, "table");
  EXPECT_NE(table.find("the baseline has no position.x.worst_case proven_max"), std::string::npos) << table;
  EXPECT_TRUE(checked(old, 0, spec()).baseline->not_in_baseline.empty());
}

TEST_F(SpecReports, OfSeveralSpecsAreTheBaselinesOfEach) {
  SpecCheck one = evaluate(spec()), two = evaluate(spec(coarser));
  one.analysis.spec.file = "cell/one.yaml";
  two.analysis.spec.file = "cell/two.yaml";
  const std::string old = write(CheckReport{{one, two}}, "json");
  const Baselines baselines = read_baselines(old, "old.json", 0);
  ASSERT_EQ(baselines.size(), 2u);
  EXPECT_EQ(&baseline_of(baselines, "cell/two.yaml", false), &baselines[1]);
  EXPECT_EQ(&baseline_of(baselines, "one.yaml", false), &baselines[0]) << "moved with its folder";
  EXPECT_THROW(baseline_of(baselines, "three.yaml", false), Error);
  EXPECT_THROW(baseline_of(baselines, "three.yaml", true), Error);
  const Spec coarse = spec(coarser);
  EXPECT_TRUE(check(coarse, {}, &baseline_of(baselines, "two.yaml", false)).all_met());
  EXPECT_FALSE(check(coarse, {}, &baseline_of(baselines, "one.yaml", false)).all_met());
}

TEST_F(SpecReports, OfFiltersAreNoBaselines) {
  const std::string text = write(filter_report(spec(), {}), "json");
  EXPECT_THROW(read_baselines(text, "old.json", 0), Error);
}

}  // namespace
}  // namespace qerr
