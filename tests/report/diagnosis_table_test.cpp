#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis_values.hpp"

namespace qerr {
namespace {

constexpr double count = 2 * std::numbers::pi / 10000;  // of the elbow of planar_prr

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Play of the elbow: five counts, with a twin.
DiagnosisReport play() {
  DiagnosisReport r = report(Verdict::explained,
                             {cause("backlash", "elbow", {{"gap", 5 * count, 4.9 * count, 5.1 * count}})});
  Cause& c = r.diagnosis.causes.front();
  c.gain.rms_after = 0.29 * count;
  c.gain.counts_after = 0.29;
  c.gain.sigma_ratio = 1;
  c.rms_without = 2.5 * count;
  c.curve = {"direction", "", {-1, 1}, {-2.5 * count, 2.5 * count}, {-2.5 * count, 2.5 * count}};
  r.diagnosis.alternatives = {{"backlash", "latency", "elbow", "reversals at two speeds"},
                              {"backlash", "latency", "elbow", "reversals at two speeds"}};
  return r;
}

Unidentified shaped(Shape shape, double amplitude, std::map<std::string, double> figures) {
  return {"elbow", "", {}, {}, amplitude, shape, std::move(figures)};
}

std::string line_of(const Unidentified& u) {
  DiagnosisReport r = report(Verdict::unexplained, {});
  r.diagnosis.unexplained = {u};
  const std::string text = table(r);
  const std::size_t at = text.find("\n  elbow: ") + 10;
  return text.substr(at, text.find('\n', at) - at);
}

TEST(DiagnosisTable, StartsWithTheVerdictInWords) {
  const std::string joint = joint_of(spec(), false);
  const Cause found = cause("backlash", joint, {{"gap", 1e-3, 0.9e-3, 1.1e-3}});
  EXPECT_NE(table(report(Verdict::explained, {found})).find("\nEXPLAINED: backlash of " + joint),
            std::string::npos);
  EXPECT_NE(table(report(Verdict::nothing_wrong, {})).find("\nNOTHING WRONG: "), std::string::npos);
  DiagnosisReport torn = report(Verdict::ambiguous, {found});
  torn.diagnosis.alternatives.push_back({"backlash", "latency", joint, "reversals at two speeds"});
  EXPECT_NE(table(torn).find("AMBIGUOUS: backlash or latency of " + joint), std::string::npos);
  EXPECT_NE(table(torn).find("    or: latency; to tell them apart, record reversals at two speeds\n"),
            std::string::npos);
  DiagnosisReport open = report(Verdict::unexplained, {});
  open.diagnosis.unexplained.push_back({joint, "periodic in the joint angle", 7.3, {}, 1e-4});
  EXPECT_NE(table(open).find("UNEXPLAINED: significant errors at " + joint), std::string::npos);
  EXPECT_NE(table(open).find("order 7.3 per revolution of the joint, amplitude 0.159 counts = 100 urad"),
            std::string::npos);
  DiagnosisReport mute = report(Verdict::cannot_judge, {});
  mute.diagnosis.reason = "the reference's noise is 2 counts; at most 0.3 would do";
  EXPECT_NE(table(mute).find("CANNOT JUDGE: the reference's noise"), std::string::npos);
}

TEST(DiagnosisTable, RoundsAFigureToItsInterval) {
  const std::string text =
      table(report(Verdict::explained,
                   {cause("backlash", joint_of(spec(), false), {{"gap", 5.6608e-4, 5.6308e-4, 5.6908e-4}})}));
  EXPECT_NE(text.find("gap 566.1 +- 3.0 urad"), std::string::npos) << text;
}

TEST(DiagnosisTable, HasARemedyForEveryEffect) {
  for (const EffectKind& kind : effect_kinds()) {
    const std::string text =
        table(report(Verdict::explained, {cause(std::string(kind.name), joint_of(spec(), false), {})}));
    EXPECT_NE(text.find("remedy: "), std::string::npos) << kind.name;
  }
}

TEST(DiagnosisTable, ShowsNoControlCharactersOfALog) {
  DiagnosisReport r =
      report(Verdict::explained, {cause("backlash", "elbow\x1b[31m", {{"gap", 1e-3, 0, 2e-3}})});
  r.log.file = "a\nb";
  EXPECT_EQ(table(r).find('\x1b'), std::string::npos);
  EXPECT_EQ(table(r).find("a\nb"), std::string::npos);
}

TEST(DiagnosisTable, LeadsWithTheAnswer) {
  EXPECT_EQ(write(play(), "table", Style{.ascii = true, .width = 76}),
            R"(qerr diagnose  robot 'planar_prr', 'log.csv': 0 rows

EXPLAINED: backlash of elbow

Causes
  backlash of elbow: gap 3.142 +- 0.063 mrad = 10.8 arcmin = 5 counts
    residual at elbow: 2.5 counts (1.57 mrad) rms without it, 0.29 counts
      (182 urad) with it
    remedy: add or subtract half the gap by the last direction of motion;
      not possible around reversals
    or: latency; to tell them apart, record reversals at two speeds
    counts against direction: o residual without this, - fit, * both
     2.5 +                                                             ----*
         |                                                     --------
         |                                             --------
         |                                     --------
       0 +                             --------
         |                     --------
         |             --------
         |     --------
    -2.5 +*----
         ++---------------+----------------+---------------+---------------+
          -1            -0.5               0              0.5              1

What remains
  elbow: 0.29 counts (182 urad) rms; quantization and the stated noise leave
    0.29 counts
)");
}

TEST(DiagnosisTable, KeepsStatisticsForTheDetails) {
  DiagnosisReport r = play();
  r.diagnosis.simulation = {{"elbow", "by_direction", 5.5, 0.01, 1e-20}};
  EXPECT_FALSE(contains(table(r), "by_direction"));
  EXPECT_FALSE(contains(table(r), "p < 1e-15") || contains(table(r), "p = "));
  const std::string details = write(r, "table", Style{.details = true, .width = 200});
  EXPECT_TRUE(contains(details, "by_direction"));
  EXPECT_TRUE(contains(details, "backlash of elbow  p = 1e-12"));
  EXPECT_LT(details.find("What remains"), details.find("by_direction"));
}

TEST(DiagnosisTable, GivesAnEffectWithoutACoordinateItsSizeInTheRecord) {
  DiagnosisReport r =
      report(Verdict::explained, {cause("latency", "elbow", {{"delay", 2e-3, 1.9e-3, 2.1e-3}})});
  r.diagnosis.causes.front().rms = 3 * count;
  EXPECT_TRUE(
      contains(table(r), "  latency of elbow: delay 2.000 +- 0.100 ms, 3 counts rms in this record\n"))
      << table(r);
}

TEST(DiagnosisTable, GroupsAlternativesByWhatToRecord) {
  DiagnosisReport r = play();
  r.diagnosis.alternatives = {{"backlash", "latency", "elbow", "reversals"},
                              {"backlash", "drift", "elbow", "reversals"},
                              {"backlash", "backlash", "shoulder", ""},
                              {"offset", "scale", "rail", "more"}};
  EXPECT_TRUE(contains(table(r),
                       "    or: latency and drift; to tell them apart, record reversals\n"
                       "    or: backlash of shoulder\n"))
      << table(r);
  EXPECT_TRUE(contains(table(r), "\n  scale of rail instead of offset; to tell them apart, record more\n"));
  for (int i = 0; i < 6; ++i)
    r.diagnosis.alternatives.push_back({"backlash", "drift", "elbow", "poses " + std::to_string(i)});
  EXPECT_TRUE(contains(table(r), "    and 4 more alternatives: --details\n"));
  EXPECT_TRUE(contains(write(r, "table", Style{.details = true, .width = 200}), "poses 5\n"));
}

TEST(DiagnosisTable, PutsFindingsAboutTheDataBeforeTheCauses) {
  DiagnosisReport r = play();
  r.diagnosis.data = {{"counts are held for 4 rows", "elbow", 17, {}, "log at the sensor's rate"},
                      {"the clock stops", "", {}, 2.5, ""},
                      {"columns are exchanged", "", {}, {}, "exchange them"}};
  const std::string text = table(r);
  EXPECT_TRUE(contains(text, R"(
The record itself
  elbow, row 17: counts are held for 4 rows
    remedy: log at the sensor's rate
  2.5 s: the clock stops
  the whole record: columns are exchanged
    remedy: exchange them
)")) << text;
  EXPECT_LT(text.find("EXPLAINED"), text.find("The record itself"));
  EXPECT_LT(text.find("The record itself"), text.find("Causes"));
}

TEST(DiagnosisTable, SaysInTheVerdictsLineThatTheRecordHasFaults) {
  DiagnosisReport r = play();
  r.diagnosis.verdict = Verdict::nothing_wrong;
  r.diagnosis.causes.clear();
  r.diagnosis.data = {{"the joint does not move", "elbow", 1, {}, "move it"}};
  EXPECT_TRUE(is_faultless(r.diagnosis));
  EXPECT_TRUE(contains(table(r), "NOTHING WRONG: the log agrees"));
  r.diagnosis.data.push_back({"2 gaps", "", 9, {}, "", DataKind::missing});
  r.diagnosis.data.push_back({"5 readings are far off", "elbow", 7, {}, "", DataKind::corrupt});
  r.diagnosis.data.push_back({"1 reading is far off", "wrist", 8, {}, "", DataKind::corrupt});
  EXPECT_FALSE(is_faultless(r.diagnosis));
  EXPECT_TRUE(
      contains(table(r), "NOTHING WRONG, BUT CORRUPT AND MISSING READINGS: apart from them the log agrees"))
      << table(r);
}

TEST(DiagnosisTable, NamesWhatIsNotJudgedInTheVerdictsLine) {
  DiagnosisReport r = play();
  r.diagnosis.unjudged = {"rail", "tip"};
  EXPECT_TRUE(contains(table(r), "; not judged: rail and tip\n")) << table(r);
  r.diagnosis.verdict = Verdict::nothing_wrong;
  r.diagnosis.causes.clear();
  EXPECT_FALSE(is_faultless(r.diagnosis));
  EXPECT_TRUE(contains(table(r), "NOTHING WRONG, BUT NOT ALL JUDGED: the log agrees")) << table(r);
  r.diagnosis.data = {{"2 gaps", "", 9, {}, "", DataKind::missing}};
  EXPECT_TRUE(contains(table(r), "NOTHING WRONG, BUT MISSING READINGS, AND NOT ALL JUDGED: apart from them"));
  EXPECT_TRUE(contains(write(r, "json", {}), "\"unjudged\": [")) << write(r, "json", {});
}

TEST(DiagnosisTable, NamesTheShapeOfWhatIsLeft) {
  EXPECT_EQ(line_of(shaped(Shape::step, 37.4 * count, {{"time", 9}})),
            "a step of 37.4 counts = 23.5 mrad = 1.35 deg at 9.00 s");
  EXPECT_EQ(line_of(shaped(Shape::hysteresis, count, {{"width", 4 * count}})),
            "hysteresis of 4 counts = 2.51 mrad = 8.64 arcmin after each reversal");
  EXPECT_EQ(line_of(shaped(Shape::exponential, count, {{"time_constant", 0.4}})),
            "an exponential after stops of 1 counts = 628 urad = 2.16 arcmin, time constant 400 ms");
  EXPECT_EQ(line_of(shaped(Shape::line, 0, {{"frequency", 50.02}})), "a line at 50.0 Hz (mains)");
  EXPECT_EQ(line_of(shaped(Shape::line, 0, {{"frequency", 120}})), "a line at 120 Hz (twice mains)");
  EXPECT_EQ(line_of(shaped(Shape::line, 0, {{"frequency", 51}})), "a line at 51.0 Hz");
  EXPECT_EQ(line_of(shaped(Shape::order, 0, {{"order", 7.3}})),
            "a sine of order 7.3 per revolution of the joint");
  EXPECT_EQ(line_of(shaped(Shape::bump, 0, {{"angle", 1.2}, {"width", 0.1}})),
            "a bump at 1.20 rad = 68.8 deg, width 100 mrad = 5.73 deg");
  EXPECT_EQ(line_of(shaped(Shape::by_count, 0, {{"divisor", 4}})), "an error that repeats every 4 counts");
  EXPECT_EQ(line_of(shaped(Shape::noise, 0.5 * count, {})),
            "scatter from row to row of 0.5 counts = 314 urad = 1.08 arcmin");
}

TEST(DiagnosisTable, NamesASingleShapeInTheVerdict) {
  DiagnosisReport r = play();
  r.diagnosis.unexplained = {shaped(Shape::step, 37.4 * count, {{"time", 9}})};
  r.diagnosis.verdict = Verdict::partly_explained;
  const std::string step = "a step of 37.4 counts = 23.5 mrad = 1.35 deg at 9.00 s";
  EXPECT_TRUE(
      contains(table(r), "PARTLY EXPLAINED: backlash of elbow; there remains " + step + " at elbow\n"));
  r.diagnosis.causes.clear();
  r.diagnosis.verdict = Verdict::unexplained;
  EXPECT_TRUE(contains(table(r), "UNEXPLAINED: elbow has " + step + ", which no effect of the catalogue"));
}

TEST(DiagnosisTable, SaysWhatToDoAboutEveryShape) {
  for (const Shape shape : {Shape::step, Shape::hysteresis, Shape::exponential, Shape::line, Shape::order,
                            Shape::bump, Shape::by_count, Shape::noise, Shape::unknown}) {
    DiagnosisReport r = report(Verdict::unexplained, {});
    r.diagnosis.unexplained = {shaped(shape, count, {}), shaped(shape, count, {})};
    const std::string text = table(r);
    const std::size_t at = text.find("What to do next\n  elbow: ");
    ASSERT_NE(at, std::string::npos) << name(shape);
    EXPECT_EQ(text.find('\n', at + 20) + 1, text.size()) << "the same advice once: " << text;
  }
}

TEST(DiagnosisTable, SaysWhatACleanRecordWouldHaveShown) {
  DiagnosisReport r = report(Verdict::nothing_wrong, {});
  r.diagnosis.visible = {{"offset", "elbow", 2.04e-5, "offset", "rad", ""},
                         {"latency", "elbow", 1e-3, "delay", "s", ""},
                         {"offset", "rail", 1e-5, "offset", "m", ""},
                         {"backlash", "rail", NAN, "gap", "m", "one way"},
                         {"latency", "rail", NAN, "delay", "s", "standstill"},
                         {"compliance", "rail", NAN, "compliance", "m/N", "standstill"}};
  const std::string text = table(r);
  EXPECT_TRUE(contains(text, R"(
What this record would have shown, from these sizes on
  effect     elbow   rail
  offset   20 urad  10 um
  latency     1 ms      -

What this motion hides
  rail, one way: backlash
  rail, standstill: latency and compliance
  `qerr diagnose SPEC --plan` proposes a motion that shows more.
)")) << text;
  r.diagnosis.verdict = Verdict::unexplained;
  EXPECT_FALSE(contains(table(r), "What this record would have shown"));
}

TEST(DiagnosisTable, FitsTheTerminal) {
  DiagnosisReport r = play();
  r.diagnosis.unexplained = {shaped(Shape::bump, count, {{"angle", 1.2}, {"width", 0.1}})};
  for (std::size_t width = 40; width <= 200; width += 20) {
    const std::string text = write(r, "table", Style{.width = width});
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = text.find('\n', at);
      EXPECT_LE(display_width(text.substr(at, end - at)), width) << text;
      at = end + 1;
    }
  }
}

}  // namespace
}  // namespace qerr
