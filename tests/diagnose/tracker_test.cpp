#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/tracked_arm.hpp"

// Columns of a tracker that are no positions of the tip, or not as their headers say.
namespace qerr {
namespace {

using testing::Arm;
using testing::Dice;

/// A clean record of a random arm, and its tracker's columns.
struct TrackedRecord {
  OperationalModel model;
  Log log;
  std::array<Eigen::Index, 3> tip{};

  explicit TrackedRecord(Dice& dice) {
    const std::size_t joints = 3 + dice.below(4);
    const Arm arm = testing::random_arm(dice, joints);
    const std::vector<double> resolution(joints, 1e-4);
    const testing::Record r = testing::motion(dice, joints, 300);
    model = arm.model(resolution);
    log = testing::log_of(dice, arm, r, resolution, 1e-5);
    for (std::size_t axis = 0; axis < 3; ++axis) tip[axis] = *log.find(LogSignal::tip, axis);
  }

  auto axis(std::size_t i) { return log.values.col(tip[i]); }
  double deviation(std::size_t i) {
    const Eigen::ArrayXd x = axis(i);
    return std::sqrt((x - x.mean()).square().mean());
  }
  Diagnosis diagnosis() const { return diagnose(model, {}, {}, log); }
};

bool says(const Diagnosis& d, const std::string& what) {
  return std::any_of(d.data.begin(), d.data.end(), [&](const DataFinding& f) {
    return f.joint == "tip" && f.what.find(what) != std::string::npos;
  });
}

void expect_no_verdict_on_the_tip(const Diagnosis& d, const std::string& case_name) {
  EXPECT_EQ(d.verdict, Verdict::unexplained) << case_name;
  EXPECT_TRUE(d.causes.empty()) << case_name << d.causes.front().effect.type;
  EXPECT_TRUE(says(d, " varies by ")) << case_name;
}

TEST(Tracker, OfNoiseIsNoReference) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Dice dice(seed);
    TrackedRecord r(dice);
    const std::size_t axis = dice.below(3);
    const double size =
        std::pow(10, dice.between(-1, 7)) * (r.deviation(0) + r.deviation(1) + r.deviation(2));
    for (std::size_t i = 0; i < 3; ++i)
      if (i == axis || seed % 2 == 0)
        for (double& x : r.axis(i)) x = dice.between(-size, size);
    expect_no_verdict_on_the_tip(r.diagnosis(), "seed " + std::to_string(seed));
  }
}

TEST(Tracker, ThatMovesMuchFartherThanTheArmIsNoReference) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Dice dice(100 + seed);
    TrackedRecord r(dice);
    r.axis(dice.below(3)) *= std::pow(10, dice.between(3, 12));
    expect_no_verdict_on_the_tip(r.diagnosis(), "seed " + std::to_string(seed));
  }
}

TEST(Tracker, HasItsColumnsExchanged) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Dice dice(200 + seed);
    TrackedRecord r(dice);
    const std::size_t i = dice.below(3), j = (i + 1 + dice.below(2)) % 3;
    const Eigen::ArrayXd kept = r.axis(i);
    r.axis(i) = r.axis(j).eval();
    r.axis(j) = kept;
    const Diagnosis d = r.diagnosis();
    EXPECT_TRUE(says(d, "look exchanged")) << seed;
    EXPECT_EQ(d.verdict, Verdict::cannot_judge) << seed;
    EXPECT_TRUE(d.causes.empty()) << seed;
  }
}

TEST(Tracker, IsInAnotherUnit) {
  const std::pair<std::string, double> units[] = {
      {"like mm", 1000}, {"like cm", 100}, {"like inch", 1 / 0.0254}};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Dice dice(300 + seed);
    TrackedRecord r(dice);
    const auto& [name, factor] = units[seed % 3];
    const Eigen::Vector3d place = 0.3 * dice.direction();
    for (std::size_t i = 0; i < 3; ++i)
      r.axis(i) = factor * (r.axis(i) + place[static_cast<Eigen::Index>(i)]);
    const Diagnosis d = r.diagnosis();
    EXPECT_TRUE(says(d, name)) << seed;
    for (const Cause& c : d.causes) EXPECT_NE(c.effect.type, "scale") << seed;
  }
}

// Neither a frame of its own nor a wrong decoding of a joint makes a tracker useless.
TEST(Tracker, MayStandAnywhere) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    Dice dice(400 + seed);
    TrackedRecord r(dice);
    const Eigen::Isometry3d frame = dice.frame(2);
    for (Eigen::Index k = 0; k < r.log.values.rows(); ++k) {
      const Eigen::Vector3d p = frame * Eigen::Vector3d(r.axis(0)[k], r.axis(1)[k], r.axis(2)[k]);
      for (std::size_t i = 0; i < 3; ++i) r.axis(i)[k] = p[static_cast<Eigen::Index>(i)];
    }
    if (seed % 2 == 0) {
      const auto counts = r.log.find(LogSignal::counts, dice.below(3));
      ASSERT_TRUE(counts);
      r.log.values.col(*counts) /= 2;
    }
    const Diagnosis d = r.diagnosis();
    for (const DataFinding& f : d.data) EXPECT_NE(f.joint, "tip") << seed << ": " << f.what;
  }
}

}  // namespace
}  // namespace qerr
