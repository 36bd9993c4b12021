#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "filter/run/cascade.hpp"
#include "qerr/bound/effect_shares.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "simulate/motion_path.hpp"
#include "support/design_filter.hpp"
#include "support/effect_experiment.hpp"

namespace qerr {
namespace {

using testing::Dice;
using testing::one_joint;
using testing::random_motion;

/// Standard deviation of a filtered signal after settling.
double filtered_sigma(const Filter& filter, const std::vector<double>& signal, std::size_t settled) {
  Cascade<double> cascade(filter);
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double x = cascade.step(signal[k]);
    if (k < settled) continue;
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<double>(signal.size() - settled);
  return std::sqrt(squares / n - sum / n * (sum / n));
}

/// Sigma of a filtered effect: by the bounds, and by filtering the effect's signal.
struct Passed {
  double said = 0, simulated = 0;
};

Passed passed(const Effect& effect, const Motion& motion, const Filter& filter,
              OperationalModel model = one_joint()) {
  const RobotUsage usage = usage_in_motion(model, motion);
  const Encoder& encoder = model.transmission.encoders[0];
  const EffectKind& kind = effect_kind(effect.type);
  const Share share = *kind.share(effect, encoder, usage.encoders[0]);
  const MotionPath path(motion);
  Action action = kind.action(effect, encoder, 1);
  std::vector<double> error;
  for (double k = 0; k < motion.duration * motion.sample_rate; ++k) {
    Moment moment{static_cast<std::uint64_t>(k), k / motion.sample_rate, 0, 0, 0};
    const double x = moment.joint = path.position(0, moment.time);
    error.push_back(kind.stage == Stage::clock ? path.position(0, action(moment.time, moment)) - x
                                               : action(x, moment) - x);
  }
  return {sigma_ratio(filter, norms(filter), share, usage.encoders[0]) * share.sigma,
          filtered_sigma(filter, error, error.size() / 5)};
}

Filter velocity_filter() { return cascade(1, 2); }

TEST(FilteredEffect, EqualsTheFilteredPeriodicErrorAtConstantSpeed) {
  const Motion motion{1000, 40, {}, {{0, 0.7, {}, {}}}, {}};
  for (const double order : {1.0, 2.0, 37.3, 300.0}) {
    const Passed p = passed({"transmission_error",
                             "elbow",
                             {{"amplitude", 1e-3}, {"phase", 0.3}, {"order", order}},
                             {{"shaft", "encoder"}}},
                            motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.02) << order;
  }
}

TEST(FilteredEffect, IsNearTheFilteredPeriodicErrorAlongASine) {
  const Motion motion{1000, 40, {}, {{0, 0, {{1.2, 0.21, 0}}, {}}}, {}};
  for (const double order : {3.0, 20.0, 90.0}) {
    const Passed p =
        passed({"transmission_error", "elbow", {{"amplitude", 1e-3}, {"phase", 0.3}, {"order", order}}, {}},
               motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.05) << order;
  }
}

TEST(FilteredEffect, IncludesTheHarmonicsOfASubdivisionError) {
  OperationalModel model = one_joint();
  model.transmission.encoders[0].counts_per_period = 64;
  const Motion motion{1000, 40, {}, {{0, 0.7, {}, {}}}, {}};
  for (const double clip : {1.0, 0.65}) {
    const Passed p = passed({"subdivision_error",
                             "elbow",
                             {{"offset_sin", 0.02}, {"gain", 0.03}, {"phase", 0.05}, {"clipping", clip}},
                             {}},
                            motion, velocity_filter(), model);
    EXPECT_NEAR(p.simulated / p.said, 1, 0.02) << clip;
  }
}

TEST(FilteredEffect, FollowsLatencyScaleAndBacklashAlongASine) {
  for (const double frequency : {0.21, 2.5, 20.0}) {
    const Motion motion{1000, 60, {}, {{0.4, 0, {{0.3, frequency, 0.1}}, {}}}, {}};
    const double least = frequency > 10 ? 0.05 : 0.03;
    for (const Effect& effect :
         {Effect{"latency", "elbow", {{"delay", 1e-3}}, {}}, Effect{"scale", "elbow", {{"scale", 1e-3}}, {}},
          Effect{"backlash", "elbow", {{"gap", 1e-3}}, {}}}) {
      const Passed p = passed(effect, motion, velocity_filter());
      EXPECT_NEAR(p.simulated / p.said, 1, least) << effect.type << ' ' << frequency;
    }
  }
}

/// Two sines of similar amplitude: the mean frequency represents both.
TEST(FilteredEffect, IsNearTheFilteredErrorAlongTwoSines) {
  Dice dice(20);
  for (int trial = 0; trial < 20; ++trial) {
    Motion motion = random_motion(dice, 1, 40);
    motion.sample_rate = 1000;
    for (const Effect& effect :
         {Effect{"latency", "elbow", {{"delay", 1e-3}}, {}}, Effect{"scale", "elbow", {{"scale", 1e-3}}, {}},
          Effect{"backlash", "elbow", {{"gap", 1e-3}}, {}},
          Effect{"transmission_error", "elbow", {{"amplitude", 1e-3}, {"order", 20}}, {}}}) {
      const Passed p = passed(effect, motion, velocity_filter());
      const double ratio = p.simulated / p.said;
      EXPECT_NEAR(ratio, 1, 0.1) << effect.type;
    }
  }
}

TEST(FilteredEffect, TreatsJitterAndNoiseAsWhiteAndConstantsAsZero) {
  const Motion motion{1000, 200, {}, {{0.4, 0, {{0.3, 0.5, 0.1}}, {}}}, {}};
  for (const Effect& effect : {Effect{"noise", "elbow", {{"sigma", 1e-3}}, {}},
                               Effect{"timing_jitter", "elbow", {{"sigma", 1e-3}}, {}}}) {
    const Passed p = passed(effect, motion, velocity_filter());
    EXPECT_NEAR(p.simulated / p.said, 1, 0.03) << effect.type;
  }
  EXPECT_EQ(
      passed({"missed_counts", "elbow", {{"counts", 4}, {"time", 1}}, {}}, motion, velocity_filter()).said,
      0);
}

}  // namespace
}  // namespace qerr
