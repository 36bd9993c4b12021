#include "qerr/report/analysis.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/filter_report.hpp"

namespace qerr {
namespace {

TEST(Analysis, GivesSigmaInMotionWhereTheSpecHasOne) {
  const Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  const Analysis a = analyze(spec);
  ASSERT_EQ(a.noise_in_motion.size(), spec.filters.size());
  for (std::size_t f = 0; f < spec.filters.size(); ++f) {
    ASSERT_TRUE(a.workspace.derivatives[f][0].sigma_in_motion);
    // All encoders have the same motion, so that the coordinate's sigma scales as theirs.
    const double factor = a.noise_in_motion[f][0] * std::sqrt(12.0) / spec.filters[f].norms.h2;
    EXPECT_NEAR(a.workspace.derivatives[f][0].sigma_in_motion->max / a.workspace.derivatives[f][0].sigma->max,
                factor, 1e-9);
    EXPECT_GT(std::abs(factor - 1), 1e-3);
  }
  for (const std::string& warning : a.warnings) EXPECT_EQ(warning.find("IPQN"), std::string::npos);
}

TEST(Analysis, WarnsOfIpqnInOneSentenceWithoutAMotion) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/planar_prr/spec.yaml");
  spec.motion.reset();
  int sentences = 0;
  for (const std::string& warning : analyze(spec).warnings)
    if (warning.find("IPQN") != std::string::npos) {
      ++sentences;
      EXPECT_NE(warning.find("'velocity_first' 0.11"), std::string::npos) << warning;
      EXPECT_NE(warning.find("motion:"), std::string::npos);
    }
  EXPECT_EQ(sentences, 1);
}

TEST(Analysis, GivesNoVerdictOnARequirementThatCannotBeDecided) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  Requirement r;
  r.quantity = "velocity_1.x.sigma_in_motion";
  r.filter = 0;
  r.bound = Requirement::Bound::sigma_in_motion;
  spec.requirements = {r};
  EXPECT_NO_THROW(analyze(spec));
  spec.motion->duration = 1e9;  // more samples than are evaluated
  EXPECT_THROW(analyze(spec), Error);
}

TEST(Analysis, WarnsOfADerivativeThatIsNotScaled) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  const auto suspicious = [&] { return filter_warnings(spec).size(); };
  EXPECT_EQ(suspicious(), 0u);
  for (const std::vector<double>& numerator : {std::vector<double>{1, -1}, {1e6, -2e6, 1e6}, {1e3, -500}}) {
    spec.filters[0].filter = filter_from_coefficients(numerator, {1}, 1000, 1);
    spec.filters[0].norms = norms(spec.filters[0].filter);
    EXPECT_EQ(suspicious(), 1u) << numerator[0];
  }
}

TEST(Analysis, UsesIpqnOnlyForAMotionOfTooManySamples) {
  Spec spec = read_spec(QERR_SOURCE_DIR "/configs/phantom_premium/experiment.yaml");
  spec.filters.resize(1);
  spec.motion->duration = 1e9;
  const Analysis a = analyze(spec);
  EXPECT_FALSE(a.workspace.derivatives[0][0].sigma_in_motion);
  EXPECT_TRUE(std::any_of(a.warnings.begin(), a.warnings.end(), [](const std::string& w) {
    return w.find("only IPQN is given") != std::string::npos;
  }));
}

}  // namespace
}  // namespace qerr
