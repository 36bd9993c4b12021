#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "report/diagnosis_values.hpp"

namespace qerr {
namespace {

nlohmann::json json(const DiagnosisReport& r) { return nlohmann::json::parse(write(r, "json", Style{})); }

TEST(DiagnosisReport, GivesParametersTheUnitOfTheirJoint) {
  const Spec s = spec();
  const std::string slide = joint_of(s, true), turn = joint_of(s, false);
  const nlohmann::json j =
      json(report(Verdict::explained, {cause("backlash", turn, {{"gap", 1e-3, 0.9e-3, 1.1e-3}}),
                                       cause("backlash", slide, {{"gap", 1e-5, 0.9e-5, 1.1e-5}}),
                                       cause("compliance", slide, {{"compliance", 1e-7, 0, 2e-7}}),
                                       cause("latency", turn, {{"delay", 0.01, 0, 0.02}})}));
  EXPECT_EQ(j["causes"][0]["parameters"][0]["unit"], "rad");
  EXPECT_EQ(j["causes"][1]["parameters"][0]["unit"], "m");
  EXPECT_EQ(j["causes"][1]["gain"]["unit"], "m");
  EXPECT_EQ(j["causes"][2]["parameters"][0]["unit"], "m/N");
  EXPECT_EQ(j["causes"][3]["parameters"][0]["unit"], "s");
}

TEST(DiagnosisReport, WritesAllParametersInTheOrderOfTheEffectsRow) {
  Cause c =
      cause("transmission_error", joint_of(spec(), false), {{"phase", 1, 0.9, 1.1}, {"amplitude", 2, 1, 3}});
  c.effect.numbers["order"] = 2;
  const nlohmann::json p = json(report(Verdict::explained, {c}))["causes"][0]["parameters"];
  ASSERT_EQ(p.size(), 3u);
  EXPECT_EQ(p[0]["name"], "amplitude");
  EXPECT_EQ(p[1]["name"], "phase");
  EXPECT_EQ(p[2]["name"], "order");
  EXPECT_EQ(p[2]["lower"], 2.0);
}

TEST(DiagnosisReport, WritesNonFiniteNumbersAsNull) {
  DiagnosisReport r = report(Verdict::explained,
                             {cause("backlash", joint_of(spec(), false), {{"gap", 1e-3, NAN, INFINITY}})});
  r.diagnosis.simulation.push_back({"elbow", "mean", NAN, 0, 0.5});
  const nlohmann::json j = json(r);
  EXPECT_TRUE(j["causes"][0]["parameters"][0]["lower"].is_null());
  EXPECT_TRUE(j["causes"][0]["parameters"][0]["upper"].is_null());
  EXPECT_TRUE(j["simulation"][0]["observed"].is_null());
  EXPECT_TRUE(j["extended_model"].is_null());
}

TEST(DiagnosisReport, WritesFindingsAboutTheDataWithTheirPlace) {
  DiagnosisReport r = report(Verdict::cannot_judge, {});
  r.diagnosis.data = {
      {"counts are held for 4 rows", "elbow", 17, {}, "log at the sensor's rate", DataKind::repeated},
      {"the clock stops", "", {}, 2.5, "log monotonic stamps"}};
  const nlohmann::json data = json(r)["data"];
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[0], nlohmann::json::parse(R"({"what": "counts are held for 4 rows", "kind": "repeated",
                                     "joint": "elbow", "row": 17, "remedy": "log at the sensor's rate"})"));
  EXPECT_EQ(data[1], nlohmann::json::parse(R"({"what": "the clock stops", "kind": "remark", "joint": null,
                                     "time": 2.5, "remedy": "log monotonic stamps"})"));
  const std::string csv = write(r, "csv", Style{});
  EXPECT_NE(csv.find("data,elbow,counts are held for 4 rows,row,17,,,,,log at the sensor's rate\r\n"),
            std::string::npos)
      << csv;
  EXPECT_NE(csv.find("data,elbow,counts are held for 4 rows,kind,,,,,,repeated\r\n"), std::string::npos)
      << csv;
  EXPECT_NE(csv.find("data,,the clock stops,time,2.5,,,,s,log monotonic stamps\r\n"), std::string::npos)
      << csv;
}

TEST(DiagnosisReport, WritesTheSmallestVisibleSizesAndWhatHidesTheOthers) {
  DiagnosisReport r = report(Verdict::nothing_wrong, {});
  r.diagnosis.visible = {{"offset", "elbow", 2e-5, "offset", "rad", ""},
                         {"backlash", "elbow", NAN, "gap", "rad", "one way"}};
  const nlohmann::json visible = json(r)["visible"];
  EXPECT_EQ(visible[0], nlohmann::json::parse(R"({"effect": "offset", "joint": "elbow", "parameter": "offset",
                                        "smallest": 2e-5, "unit": "rad", "hidden_by": null})"));
  EXPECT_EQ(visible[1], nlohmann::json::parse(R"({"effect": "backlash", "joint": "elbow", "parameter": "gap",
                                        "smallest": null, "unit": "rad", "hidden_by": "one way"})"));
  const std::string csv = write(r, "csv", Style{});
  EXPECT_NE(csv.find("visible,elbow,backlash,smallest gap,,,,,rad,one way\r\n"), std::string::npos) << csv;
}

TEST(DiagnosisReport, WritesTheShapeOfAResidualWithItsFiguresInSi) {
  const std::string slide = joint_of(spec(), true);
  DiagnosisReport r = report(Verdict::unexplained, {});
  r.diagnosis.unexplained = {{slide, "", {}, {}, 1e-4, Shape::bump, {{"angle", 0.2}, {"width", 0.01}}},
                             {"elbow", "", {}, 50.0, 1e-4, Shape::line, {{"frequency", 50.0}}}};
  const nlohmann::json list = json(r)["unexplained"];
  EXPECT_EQ(list[0]["shape"], "bump");
  EXPECT_EQ(list[0]["figures"], nlohmann::json::parse(R"({"angle": 0.2, "width": 0.01})"));
  EXPECT_EQ(list[0]["units"], nlohmann::json::parse(R"({"angle": "m", "width": "m"})"));
  EXPECT_TRUE(list[0]["curve"].is_null());
  EXPECT_EQ(list[1]["units"]["frequency"], "Hz");
  EXPECT_EQ(list[1]["frequency"], 50.0);
  const std::string csv = write(r, "csv", Style{});
  EXPECT_NE(csv.find(",bump.width,0.01,,,,m,\r\n"), std::string::npos) << csv;
}

TEST(DiagnosisReport, WritesWhatEachCauseAddsAndItsCurve) {
  const std::string joint = joint_of(spec(), false);
  DiagnosisReport r = report(Verdict::explained, {cause("backlash", joint, {{"gap", 1e-3, 0, 2e-3}})});
  Cause& c = r.diagnosis.causes.front();
  EXPECT_FALSE(json(r)["causes"][0].contains("counts"));
  EXPECT_TRUE(json(r)["causes"][0]["rms_without"].is_null());
  c.rms = 4e-4;
  c.rms_without = 5e-4;
  c.curve = {"direction", "", {-1, 1}, {-4e-4, NAN}, {-4e-4, 4e-4}};
  const nlohmann::json entry = json(r)["causes"][0];
  const std::size_t place = spec().model.chain.independent.front().name == joint ? 0 : 1;
  EXPECT_DOUBLE_EQ(entry["counts"], c.rms / spec().model.transmission.encoders[place].resolution);
  EXPECT_EQ(entry["rms_without"], 5e-4);
  EXPECT_EQ(entry["curve"]["against"], "direction");
  EXPECT_TRUE(entry["curve"]["residual"][1].is_null());
}

/// Whether the report has the form of its own schema.
bool conforms(const nlohmann::json& report) {
  valijson::Schema schema;
  valijson::SchemaParser parser;
  const nlohmann::json text = nlohmann::json::parse(output_schema("diagnose"));
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  valijson::Validator validator;
  return validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(report), nullptr);
}

TEST(DiagnosisReport, ConformsToItsSchemaWithAllMembers) {
  const std::string joint = joint_of(spec(), false);
  DiagnosisReport r = report(Verdict::partly_explained, {cause("backlash", joint, {{"gap", 1e-3, 0, 2e-3}})});
  r.diagnosis.causes.front().curve = {"angle", "rad", {0, 1}, {1e-3, NAN}, {1e-3, 1e-3}};
  r.diagnosis.data = {{"held", joint, 17, 2.5, "mend it"}, {"held", "", {}, {}, ""}};
  r.diagnosis.visible = {{"offset", joint, 1e-5, "offset", "rad", ""}, {"drift", joint, NAN, "", "", "rest"}};
  r.diagnosis.unexplained = {{joint, "", {}, {}, 1e-4, Shape::step, {{"time", 9}}},
                             {joint, "slow", 2.0, 3.0, 1e-4, Shape::unknown, {}}};
  const nlohmann::json whole = json(r);
  EXPECT_TRUE(conforms(whole)) << whole.dump(1);
  for (const auto& [list, member] : {std::pair{"data", "what"},
                                     {"data", "kind"},
                                     {"visible", "smallest"},
                                     {"unexplained", "shape"},
                                     {"causes", "rms_without"}}) {
    nlohmann::json broken = whole;
    broken[list][0].erase(member);
    EXPECT_FALSE(conforms(broken)) << list << '.' << member << " is required";
  }
  nlohmann::json wrong = whole;
  wrong["unexplained"][0]["shape"] = "zigzag";
  EXPECT_FALSE(conforms(wrong));
}

TEST(DiagnosisReport, ListsUnwrappedColumns) {
  DiagnosisReport r = report(Verdict::nothing_wrong, {});
  LogColumn column;
  column.header = "elbow.reference [rad]";
  column.wraps.count = 3;
  r.log.columns.push_back(column);
  EXPECT_EQ(json(r)["log"]["unwrapped"][0]["column"], "elbow.reference [rad]");
  EXPECT_NE(table(r).find("unwrapped: elbow.reference [rad], 3 full turns"), std::string::npos);
  column.signal = LogSignal::reference;
  r.log.columns = {column};
  EXPECT_NE(table(r).find("unwrapped: elbow.reference [rad], whole turns in 3 rows"), std::string::npos);
}

TEST(DiagnosisReport, GivesTheGainAtTheTipInMetresWithoutCounts) {
  const std::string turn = joint_of(spec(), false);
  DiagnosisReport r =
      report(Verdict::explained, {cause("eccentricity", turn, {{"amplitude", 1e-3, 0.9e-3, 1.1e-3}})});
  Gain at_tip{2e-3, 4e-4, true, 4.5, 5.5};
  at_tip.unit = "m";
  at_tip.of_tip = true;
  r.diagnosis.causes[0].gain = r.diagnosis.gain = at_tip;
  const nlohmann::json of_cause = json(r)["causes"][0]["gain"];
  EXPECT_EQ(of_cause["unit"], "m");
  EXPECT_TRUE(of_cause["counts_before"].is_null());
  EXPECT_TRUE(of_cause["coverage"].is_null());
  EXPECT_EQ(json(r)["causes"][0]["parameters"][0]["unit"], "rad");
  const std::string text = write(r, "table", Style{.details = true, .width = 200});
  EXPECT_NE(text.find("  the tip        2.00 mm  400 um              -      -"), std::string::npos) << text;
  EXPECT_NE(text.find("residual at the tip: 2.00 mm rms without any cause, 400 um with all\n"),
            std::string::npos)
      << text;
  const std::string csv = write(r, "csv", Style{});
  EXPECT_NE(csv.find("rms_after,4e-04,,,,m,"), std::string::npos) << csv;
  EXPECT_EQ(csv.find("counts_before"), std::string::npos) << csv;
}

TEST(DiagnosisReport, HasTheSameFiguresOfTheGainInCsvAsInJson) {
  const DiagnosisReport r = report(Verdict::nothing_wrong, {});
  const std::string csv = write(r, "csv", Style{});
  const nlohmann::json gain = json(r)["gain"];
  for (const char* figure : {"rms_before", "rms_after", "ratio", "counts_before", "counts_after",
                             "sigma_ratio", "log_score", "coverage"}) {
    const std::string row = std::string("gain,,,") + figure + ',' + shortest(gain[figure]) + ',';
    EXPECT_NE(csv.find(row), std::string::npos) << row << csv;
  }
}

TEST(DiagnosisReport, WritesCsvRowsOfEqualLength) {
  DiagnosisReport r = report(Verdict::partly_explained,
                             {cause("backlash", joint_of(spec(), false), {{"gap", 1e-3, 0, 2e-3}})});
  r.diagnosis.unexplained.push_back({"a, \"b\"", "slow in time", {}, 0.01, 1e-4});
  const std::string text = write(r, "csv", Style{});
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find("\r\n", at);
    bool quoted = false;
    int cells = 1;
    for (std::size_t i = at; i < end; ++i) {
      quoted ^= text[i] == '"';
      cells += text[i] == ',' && !quoted;
    }
    EXPECT_EQ(cells, 10) << text.substr(at, end - at);
    at = end + 2;
  }
}

}  // namespace
}  // namespace qerr
