#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/comparison.hpp"
#include "qerr/report/write.hpp"
#include "report/compare/parts.hpp"
#include "report/rows.hpp"

namespace qerr {
namespace {

/// A spec of a robot of three joints, and requirements.
Spec premium(const std::string& requirements, const std::string& encoder = "{bits: 14}") {
  const std::string folder = QERR_SOURCE_DIR "/configs/phantom_premium/";
  return parse_spec(
      "qerr: 1\nrobot: {urdf: phantom_premium.urdf}\nencoders: {'*': " + encoder +
          "}\nconfigurations: {count: 500}\nfilters: {velocity: {derivative: 1, sample_rate: 1 kHz}}\n" +
          "requirements: [" + requirements + "]\n",
      folder + "proofs.yaml");
}

std::string required(const std::string& relation, double limit,
                     const std::string& quantity = "position.x.worst_case") {
  return "{quantity: " + quantity + ", statistic: proven_max, " + relation + ": " +
         std::to_string(limit * 1e6) + " um}";
}

Requirement limit_on_proof(bool at_least, double value) {
  Requirement r;
  r.proven = true;
  r.at_least = at_least;
  r.limit = value;
  return r;
}

TEST(ProvenRequirement, IsMetWhereTheProofDecides) {
  const ProvenMaximum proven{1.0, 1.02, Eigen::VectorXd::Zero(1)};
  EXPECT_TRUE(evaluate(limit_on_proof(false, 1.02), proven).met);
  EXPECT_FALSE(evaluate(limit_on_proof(false, 1.019), proven).met);
  EXPECT_TRUE(evaluate(limit_on_proof(false, 1.019), proven).undecided);
  EXPECT_FALSE(evaluate(limit_on_proof(false, 0.999), proven).met);
  EXPECT_FALSE(evaluate(limit_on_proof(false, 0.999), proven).undecided);
  EXPECT_TRUE(evaluate(limit_on_proof(true, 1.0), proven).met);
  EXPECT_TRUE(evaluate(limit_on_proof(true, 1.01), proven).undecided);
  EXPECT_FALSE(evaluate(limit_on_proof(true, 1.03), proven).undecided);
  EXPECT_EQ(evaluate(limit_on_proof(false, 1), proven).value, 1.02);
  EXPECT_EQ(evaluate(limit_on_proof(true, 1), proven).value, 1.0);
}

TEST(ProvenRequirement, IsProvenAgainWithTheGapThatDecides) {
  const ProvenMaximum proven{1.0, 1.01, {}};
  EXPECT_NEAR(deciding_gap(limit_on_proof(false, 1.004), proven, 0.01), 0.004, 1e-15);
  EXPECT_NEAR(deciding_gap(limit_on_proof(false, 1.0001), proven, 0.01), 0.001, 1e-15);
  EXPECT_NEAR(deciding_gap(limit_on_proof(false, 2), proven, 0.01), 0.01, 1e-15);
}

TEST(ProvenRequirement, IsDecidedWithinATenthOfTheGap) {
  const SpecCheck wide = evaluate(premium(required("at_most", 1e-6)));
  const ProvenMaximum& proven = *wide.results.at(0).proven;
  ASSERT_FALSE(wide.results[0].met);
  for (const double above : {1.0015, 1.004, 1.02}) {
    const SpecCheck checked = evaluate(premium(required("at_most", above * proven.lower)));
    EXPECT_TRUE(checked.results.at(0).met) << above;
    EXPECT_LE(checked.results[0].value, above * proven.lower);
  }
  EXPECT_FALSE(evaluate(premium(required("at_most", 0.9999 * proven.lower))).results.at(0).met);
  EXPECT_TRUE(evaluate(premium(required("at_least", 0.9999 * proven.lower))).results.at(0).met);
  EXPECT_FALSE(evaluate(premium(required("at_least", 1.02 * proven.lower))).results.at(0).met);
}

TEST(ProvenRequirement, OnSigmaOfUnknownSpectrumIsAnErrorAtItsLine) {
  try {
    evaluate(
        premium("{quantity: velocity.x.sigma, statistic: proven_max, at_most: 1 mm/s}]\n"
                "effects: [{type: eccentricity, joint: waist, amplitude: 1 mrad}"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("proofs.yaml:6"), std::string::npos) << e.what();
  }
}

TEST(ProvenRequirement, IsNotEvaluatedWithTheSample) {
  const Spec spec = premium(required("at_most", 1e-6));
  EXPECT_THROW(evaluate(spec.requirements.at(0), Workspace{}, {}, {}), Error);
}

TEST(Proofs, StandInEveryFormat) {
  const Analysis a = analyze(premium(""), {}, {.gap = 0.05, .all = true});
  ASSERT_EQ(a.proofs.size(), 12u);
  const Json json = parse_json(write(a, "json"), "report");
  const Json& worst = json.at("position").at(0).at("worst_case");
  const Json& proven = worst.at("proven");
  EXPECT_GE(proven.at("lower").get<double>(), worst.at("max").get<double>());
  EXPECT_NEAR(proven.at("gap").get<double>(),
              proven.at("upper").get<double>() / proven.at("lower").get<double>() - 1, 1e-15);
  EXPECT_EQ(proven.at("at").size(), 3u);
  const std::string csv = write(a, "csv"), table = write(a, "table");
  EXPECT_NE(csv.find("position,,x,m,worst_case,proven_lower,"), std::string::npos);
  EXPECT_NE(csv.find("derivative,velocity,z,m/s,sigma,proven_max,"), std::string::npos);
  EXPECT_NE(table.find("proven"), std::string::npos);
  EXPECT_EQ(write(analyze(premium("")), "table").find("proven"), std::string::npos);
}

TEST(Proofs, BehindAFilterAreThoseOfThePositionTimesItsNorm) {
  const Analysis a = analyze(premium(""), {}, {.gap = 0.05, .all = true});
  const Norms& norms = a.spec.filters.at(0).norms;
  const ProvenMaximum &position = *find_proof(a, {1, -1, Bound::sigma}),
                      &velocity = *find_proof(a, {1, 0, Bound::sigma});
  EXPECT_NEAR(velocity.lower, norms.h2 * position.lower, 1e-12 * velocity.lower);
  EXPECT_NEAR(velocity.upper, norms.h2 * position.upper, 1e-12 * velocity.upper);
  EXPECT_EQ(position.at, velocity.at);
}

TEST(Proofs, AreComparedAsProvenMaxima) {
  const NamedFigures figures = named_figures(evaluate(premium(required("at_most", 1))));
  const auto proven = std::find_if(figures.figures.begin(), figures.figures.end(),
                                   [](const NamedFigure& f) { return f.statistic == "proven_max"; });
  ASSERT_NE(proven, figures.figures.end());
  EXPECT_EQ(proven->name(), "position.x.worst_case proven_max");
  EXPECT_EQ(figures.requirements.at(0).figure.value, proven->value);
}

TEST(Proofs, WarnOfAWideGapOnly) {
  const auto warned = [](const Analysis& a, const std::string& text) {
    return std::any_of(a.warnings.begin(), a.warnings.end(),
                       [&](const auto& w) { return w.find(text) != w.npos; });
  };
  EXPECT_FALSE(warned(analyze(premium(""), {}, {.gap = 0.05, .all = true}), "gap"));
  Spec euler = premium("");
  euler.model.coordinates = {Coordinate::yaw};
  EXPECT_TRUE(warned(analyze(euler, {}, {.gap = 0.05, .all = true}),
                     "no upper bound over the joint ranges is known"));
}

}  // namespace
}  // namespace qerr
