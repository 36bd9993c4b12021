#include <gtest/gtest.h>

#include <numeric>

#include "qerr/report/analysis.hpp"

namespace qerr {
namespace {

Analysis analysis(const std::string& config, std::vector<std::pair<std::string, std::string>> changes) {
  changes.emplace_back("configurations.count", "2000");
  return analyze(read_spec(std::string(QERR_SOURCE_DIR "/configs/") + config, {changes, {}}));
}

TEST(BudgetParts, AddUpToTheBudget) {
  for (const char* effects : {"[]", "[{type: backlash, joint: j2, gap: 0.1 mrad}]"}) {
    const Analysis a = analysis(
        "barrett_wam/spec.yaml",
        {{"encoders", "{'*': {resolution: 0.125 mrad, accuracy: 0.05 mrad}}"}, {"effects", effects}});
    const std::vector<double> budget = encoder_budget(a);
    const std::vector<BudgetParts> parts = budget_parts(a);
    double effect = 0;
    for (std::size_t e = 0; e < parts.size(); ++e) {
      EXPECT_NEAR(parts[e].quantization + parts[e].accuracy + parts[e].effects, budget[e], 1e-12);
      effect += parts[e].effects;
    }
    EXPECT_EQ(effect > 0, effects != std::string("[]"));
  }
}

TEST(BudgetParts, OfQuantizationAreThoseOfASpecWithoutAccuracy) {
  const auto encoders = [](const std::string& accuracy) {
    return std::pair<std::string, std::string>("encoders",
                                               "{'*': {resolution: 0.125 mrad, accuracy: " + accuracy + "}}");
  };
  // Two differentials: the columns of these encoders are not those of their joints.
  const Analysis with = analysis("barrett_wam/spec.yaml", {encoders("0.05 mrad")});
  const Analysis without = analysis("barrett_wam/spec.yaml", {encoders("0 rad")});
  EXPECT_LT((with.workspace.mean_quantization_parts - without.workspace.mean_variance_parts).norm(),
            1e-12 * without.workspace.mean_variance_parts.norm());
  // Delta^2/12 and A^2/2 with Delta = 2.5 A.
  const double quantization = 2.5 * 2.5 / 12, all = quantization + 0.5;
  double sum = 0;
  for (const BudgetParts& p : budget_parts(with)) sum += p.quantization;
  EXPECT_NEAR(sum, quantization / all, 1e-12);
}

TEST(BudgetParts, OfAnIdealModelAreAllQuantization) {
  const Analysis a = analysis("kuka_lwr/spec.yaml", {});
  const std::vector<double> budget = encoder_budget(a);
  const std::vector<BudgetParts> parts = budget_parts(a);
  for (std::size_t e = 0; e < parts.size(); ++e) {
    EXPECT_DOUBLE_EQ(parts[e].quantization, budget[e]);
    EXPECT_EQ(parts[e].accuracy, 0);
    EXPECT_EQ(parts[e].effects, 0);
  }
}

/// What finer counts lower the variance by is the share of the resolution, with effects that follow a motion,
/// too.
TEST(BudgetParts, OfQuantizationAreWhatFinerCountsTakeOffAlongAMotion) {
  const auto with = [](const std::string& resolution) {
    return analysis("kuka_lwr/spec.yaml",
                    {{"encoders", "{'*': {resolution: " + resolution + "}}"},
                     {"effects", "[{type: eccentricity, joint: a2, amplitude: 100 urad, shaft: joint}]"},
                     {"motion",
                      "{sample_rate: 100 Hz, duration: 4 s, joints: {a2: {sines: [{amplitude: 1 rad, "
                      "frequency: 0.5 Hz}]}, a4: {sines: [{amplitude: 1 rad, frequency: 0.7 Hz}]}}}"}});
  };
  const Analysis coarse = with("100 urad"), fine = with("1 nrad");
  double share = 0, effects = 0;
  for (const BudgetParts& p : budget_parts(coarse)) share += p.quantization, effects += p.effects;
  const double before = coarse.workspace.mean_covariance.topLeftCorner<3, 3>().trace(),
               after = fine.workspace.mean_covariance.topLeftCorner<3, 3>().trace();
  EXPECT_NEAR(share, 1 - after / before, 0.05);  // the effect's variance is that of one pose at the tip
  EXPECT_GT(effects, 0.1);
}

}  // namespace
}  // namespace qerr
