#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "qerr/core/error.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/sensing.hpp"

namespace qerr {
namespace {

Motion motion_of(JointMotion joint) { return {1000, 10, {}, {std::move(joint)}, {}}; }

/// Central difference of order 4.
double slope(const MotionPath& path, double t, double h) {
  return (8 * (path.position(0, t + h) - path.position(0, t - h)) -
          (path.position(0, t + 2 * h) - path.position(0, t - 2 * h))) /
         (12 * h);
}

TEST(MotionPath, SumsCenterVelocityAndSines) {
  const MotionPath path(motion_of({0.5, 0.25, {{2, 3, 0.7}, {1, 5, 0}}, {}}));
  for (const double t : {0.0, 0.1, 1.7, 9.99}) {
    const double q =
        0.5 + 0.25 * t + 2 * std::sin(6 * std::numbers::pi * t + 0.7) + std::sin(10 * std::numbers::pi * t);
    EXPECT_NEAR(path.position(0, t), q, 1e-13);
    EXPECT_NEAR(path.velocity(t)[0], slope(path, t, 1e-4), 1e-6);
  }
}

class Moves : public ::testing::TestWithParam<int> {};

TEST_P(Moves, KeepTheirLimitsAndStopAtTheirEnds) {
  std::mt19937 engine(static_cast<unsigned>(GetParam()));
  const auto draw = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(engine));
  };
  const double sign = engine() % 2 ? 1 : -1;
  const Move out{sign * draw(1e-3, 3), draw(0.05, 5), draw(0.1, 50), engine() % 2 ? draw(1, 1000) : 0, 0.3};
  Move back = out;
  back.to = 0.1;
  const MotionPath path(motion_of({0, 0, {}, {out, back}}));
  double ends = 0, fastest = 0, hardest = 0;
  for (double t = 0; t < 40; t += 1e-3) {
    const double h = 1e-6, v = path.velocity(t)[0], q = path.position(0, t);
    ASSERT_LE(std::abs(v), out.velocity * (1 + 1e-9)) << t;
    ASSERT_NEAR((path.position(0, t + h) - q) / h, v, 1e-5 * (1 + out.acceleration)) << t;
    const double a = (path.velocity(t + h)[0] - v) / h;
    ASSERT_LE(std::abs(a), out.acceleration * (1 + 1e-4) + 1e-6) << t;
    if (out.jerk > 0) {
      const double later = (path.velocity(t + 1e-3 + h)[0] - path.velocity(t + 1e-3)[0]) / h;
      ASSERT_LE(std::abs(later - a), 1e-3 * out.jerk * (1 + 1e-3) + 1e-5 * (1 + out.acceleration)) << t;
    }
    ASSERT_GE(q, std::min(0.0, out.to) - 1e-9);
    ASSERT_LE(q, std::max(back.to, out.to) + 1e-9);
    ends += std::abs(q - out.to) < 1e-12 && v == 0;
    fastest = std::max(fastest, std::abs(v));
    hardest = std::max(hardest, std::abs(a));
  }
  EXPECT_GE(ends, 299) << "rests at its end for the dwell";
  // The fastest such motion reaches a limit.
  if (out.jerk == 0) {
    EXPECT_TRUE(fastest > 0.99 * out.velocity || hardest > 0.99 * out.acceleration);
  }
}
INSTANTIATE_TEST_SUITE_P(Random, Moves, ::testing::Range(0, 60));

/// By hand: 1 rad within 1 rad/s and 2 rad/s^2 takes 1/1 + 1/2 s.
TEST(MotionPath, ATrapezoidTakesDistanceOverSpeedPlusSpeedOverAcceleration) {
  const MotionPath path(motion_of({0, 0, {}, {{1, 1, 2, 0, 100}}}));
  EXPECT_LT(path.position(0, 1.5 - 1e-3), 1);
  EXPECT_DOUBLE_EQ(path.position(0, 1.5), 1);
  EXPECT_NEAR(path.position(0, 0.75), 0.5, 1e-12);
}

/// With jerk j and acceleration a reached: distance/v + v/a + a/j.
TEST(MotionPath, AJerkLimitedMoveTakesTheAccelerationOverJerkLonger) {
  const MotionPath path(motion_of({0, 0, {}, {{1, 1, 2, 20, 100}}}));
  EXPECT_LT(path.position(0, 1.6 - 1e-2), 1 - 1e-7);
  EXPECT_NEAR(path.position(0, 1.6), 1, 1e-12);
}

TEST(MotionPath, ATableIsExactInItsRowsAndConstantOutside) {
  Motion motion{100, 0.9, {}, {}, {{2, 2.1, 2.3, 2.9}, Eigen::MatrixXd(2, 4)}};
  motion.table.positions << 1, 2, 4, 3, 0, 0, 0.5, 0.25;
  const MotionPath path(motion);
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(path.position(motion.table.time[static_cast<std::size_t>(i)] - 2)
                    .isApprox(motion.table.positions.col(i), 1e-12));
  EXPECT_EQ(path.position(5)[0], 3);
  EXPECT_EQ(path.velocity(5)[0], 0);
  for (const double t : {0.05, 0.15, 0.5, 0.8}) EXPECT_NEAR(path.velocity(t)[0], slope(path, t, 1e-5), 1e-6);
}

TEST(MotionPath, ATableOfAStraightLineIsAStraightLine) {
  Motion motion{100, 1, {}, {}, {{0, 0.3, 0.4, 1}, Eigen::MatrixXd(1, 4)}};
  motion.table.positions << 1, 1.6, 1.8, 3;
  const MotionPath path(motion);
  for (double t = 0; t <= 1; t += 0.01) EXPECT_NEAR(path.position(0, t), 1 + 2 * t, 1e-12);
}

TEST(MotionPath, ATableOfACubicIsTheCubicAndItsAccelerationIsContinuous) {
  const auto cubic = [](double t) { return 1 + t * (2 + t * (-3 + t)); };
  for (const std::vector<double>& times : {std::vector<double>{0, 0.3, 0.4, 1, 1.7}, {0, 0.5, 1.1, 2}}) {
    const auto n = static_cast<Eigen::Index>(times.size());
    Motion motion{100, times.back(), {}, {}, {times, Eigen::MatrixXd(2, n)}};
    for (Eigen::Index i = 0; i < n; ++i) {
      motion.table.positions(0, i) = cubic(times[static_cast<std::size_t>(i)]);
      motion.table.positions(1, i) = std::sin(5.0 * static_cast<double>(i));
    }
    const MotionPath path(motion);
    for (double t = 0; t <= times.back(); t += 0.01) {
      EXPECT_NEAR(path.position(0, t), cubic(t), 1e-12);
      EXPECT_NEAR(path.acceleration(t)[0], -6 + 6 * t, 1e-9);
    }
    for (std::size_t i = 1; i + 1 < times.size(); ++i)
      EXPECT_NEAR(path.acceleration(times[i] - 1e-9)[1], path.acceleration(times[i] + 1e-9)[1], 1e-5);
  }
}

class MotionSpec : public ::testing::Test {
 protected:
  std::string message(const std::string& motion, const std::string& csv = "") {
    const auto folder = std::filesystem::temp_directory_path() / ("qerr_motion_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "motion.csv") << csv;
    std::ofstream(folder / "spec.yaml")
        << "qerr: 1\nrobot: {urdf: '" QERR_SOURCE_DIR
           "/tests/corpus/arm.urdf'}\nencoders:\n  '*': {bits: 14}\n  lift: {resolution: 10 um}\n"
           "configurations: {count: 5, limits: {wrist: [-180 deg, 180 deg]}}\nmotion: "
        << motion << '\n';
    std::string text = "accepted";
    try {
      spec = read_spec((folder / "spec.yaml").string());
    } catch (const Error& e) {
      text = e.what();
    }
    std::filesystem::remove_all(folder);
    return text;
  }
  Spec spec;
};

TEST_F(MotionSpec, OutsideTheJointLimitsIsAnErrorThatNamesTheJoint) {
  const std::string text =
      message("{sample_rate: 100 Hz, duration: 1 s, joints: {lift: {center: 10 m}, elbow: {center: 0}}}");
  EXPECT_NE(text.find("motion.joints.lift"), std::string::npos) << text;
  EXPECT_NE(text.find("exceeds the limits of the joint"), std::string::npos) << text;
}

TEST_F(MotionSpec, SinesThatDoNotCoincideMayEachUseTheFullRange) {
  const Limits limits = [&] {
    EXPECT_EQ(message("{sample_rate: 100 Hz, duration: 1 s, joints: {elbow: {center: 0}}}"), "accepted");
    for (const IndependentJoint& joint : spec.model.chain.independent)
      if (joint.name == "elbow") return *joint.limits;
    return Limits{};
  }();
  const std::string a = std::to_string(0.9 * limits.upper);
  const std::string sines =
      "{amplitude: " + a + ", frequency: 1, phase: 0}, {amplitude: " + a + ", frequency: 1, phase: 180 deg}";
  EXPECT_EQ(message("{sample_rate: 100 Hz, duration: 1 s, joints: {elbow: {sines: [" + sines + "]}}}"),
            "accepted");
}

TEST_F(MotionSpec, AFileGivesItsRateAndDuration) {
  const std::string csv =
      "time [s],shoulder [deg],lift [mm],elbow [rad],wrist [rad]\n0,0,1,0,0\n0.01,1,2,0,0\n0.02,2,3,0,0\n";
  ASSERT_EQ(message("{file: motion.csv}", csv), "accepted");
  EXPECT_NEAR(spec.motion->sample_rate, 100, 1e-9);
  EXPECT_NEAR(spec.motion->duration, 0.03, 1e-12);
  EXPECT_NEAR(spec.motion->table.positions(0, 2), std::numbers::pi / 90, 1e-15);
  EXPECT_NEAR(spec.motion->table.positions(2, 1), 2e-3, 1e-15);  // lift is the third joint of the chain
}

TEST_F(MotionSpec, AJointWithoutAColumnRestsUnlessItMayHaveAnotherName) {
  ASSERT_EQ(message("{file: motion.csv}", "time,elbow [deg],elbow.effort\n0,1,0\n0.01,2,0\n"), "accepted");
  const auto elbow = static_cast<Eigen::Index>(independent_index(spec.model.chain, "elbow"));
  EXPECT_NEAR(spec.motion->table.positions(elbow, 1), std::numbers::pi / 90, 1e-15);
  EXPECT_NEAR(spec.motion->table.positions.col(1).cwiseAbs().sum(), std::numbers::pi / 90, 1e-15);
  EXPECT_TRUE(std::any_of(spec.warnings.begin(), spec.warnings.end(),
                          [](const std::string& w) { return w.find("at rest at 0") != std::string::npos; }));
  for (const std::string other : {"shulder", "shoulder.velocity", "shoulder.counts"})
    EXPECT_NE(
        message("{file: motion.csv}", "time,elbow," + other + "\n0,0,0\n0.01,0,0\n").find("would rest at 0"),
        std::string::npos);
}

TEST_F(MotionSpec, AFileIsWhateverALogCanBe) {
  const std::string table =
      "Bench 4;;;;;\nZeit in ms;shoulder.reference (deg);shoulder.measured;Hub [mm];elbow;wrist\n"
      "0;0;7;1;0;0\n10;1,5;7;2;0;0\n20;3;7;3;0;0\n";
  ASSERT_EQ(message("{file: motion.csv}\nlog: {columns: {lift.reference: Hub}}", table), "accepted");
  EXPECT_NEAR(spec.motion->sample_rate, 100, 1e-9);
  EXPECT_NEAR(spec.motion->table.positions(0, 1), std::numbers::pi / 120, 1e-15) << "the truth is the motion";
  EXPECT_NEAR(spec.motion->table.positions(2, 2), 3e-3, 1e-15);
  EXPECT_NE(message("{file: motion.csv}", table).find("lift.reference: COLUMN"), std::string::npos);
}

TEST_F(MotionSpec, AFileMayStateEffortsAndTemperatures) {
  const std::string csv =
      "time,shoulder,lift,elbow,wrist,elbow.effort [mA],lift.temperature [degC]\n"
      "0,0,0,0,0,500,20\n0.01,0,0,0,0,700,24\n0.02,0,0,0,0,600,25\n";
  ASSERT_EQ(message("{file: motion.csv}", csv), "accepted");
  const MotionTable& table = spec.motion->table;
  ASSERT_TRUE(states_any(table.efforts) && states_any(table.temperatures));
  const std::size_t elbow = independent_index(spec.model.chain, "elbow"),
                    lift = independent_index(spec.model.chain, "lift");
  EXPECT_EQ(table.efforts[elbow].unit, "A");
  const MotionPath path(*spec.motion);
  EXPECT_NEAR(path.along(table.efforts[elbow], 0.0025), 0.55, 1e-12);
  EXPECT_NEAR(path.along(table.efforts[elbow], 1), 0.6, 1e-12) << "after its end the last";
  EXPECT_EQ(table.efforts[lift].values.size(), 0);
  // What loads and warms the joints: 0.2 rad/A and 1 mm/K.
  const std::vector<Effect> effects{
      {"compliance", "elbow", {{"compliance", 0.2}}, {}},
      {"drift", "lift", {{"amplitude", 0}, {"time_constant", 1}, {"coefficient", 1e-3}}, {}}};
  Sensing sensing(spec.model, *spec.motion, effects, {Eigen::VectorXd::Zero(4), 1, false, false});
  const double efforts[] = {0.5, 0.7, 0.6}, rises[] = {0, 4, 5};
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Reading& r = sensing.read(k);
    EXPECT_NEAR(r.estimate[static_cast<Eigen::Index>(elbow)], 0.2 * efforts[k], 1e-12);
    EXPECT_NEAR(r.estimate[static_cast<Eigen::Index>(lift)], 1e-3 * rises[k], 1e-12);
  }
  EXPECT_NE(message("{file: motion.csv}", "time,shoulder,lift,elbow,wrist,elbow.effort [mm]\n0,0,0,0,0,5\n")
                .find("wrong unit"),
            std::string::npos);
}

TEST_F(MotionSpec, AFileWithUnevenTimesNeedsASampleRate) {
  const std::string csv = "time,shoulder,lift,elbow,wrist\n0,0,0,0,0\n0.01,0,0,0,0\n0.05,0,0,0,0\n";
  EXPECT_NE(message("{file: motion.csv}", csv).find("sample_rate"), std::string::npos);
  EXPECT_EQ(message("{file: motion.csv, sample_rate: 1 kHz}", csv), "accepted");
}

TEST_F(MotionSpec, TimeThatDoesNotIncreaseIsAnErrorWithItsLine) {
  const std::string csv = "time,shoulder,lift,elbow,wrist\n0,0,0,0,0\n0.01,0,0,0,0\n0.01,0,0,0,0\n";
  EXPECT_NE(message("{file: motion.csv}", csv).find("motion.csv:4:1"), std::string::npos);
}

}  // namespace
}  // namespace qerr
