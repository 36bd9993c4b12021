#include "simulate/noise_along_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"

namespace qerr {
namespace {

constexpr double pi = std::numbers::pi;

/// Root mean square of the filtered error of a quantizer along x(k), over 400 random positions of its zero.
template <class Path>
double simulated(int derivative, int order, Path x, int samples) {
  const double a = std::exp(-2 * pi * 0.05);
  std::mt19937 engine(5);
  double sum = 0;
  for (int run = 0; run < 400; ++run) {
    const double zero = std::uniform_real_distribution(0.0, 1.0)(engine);
    std::vector<double> before(static_cast<std::size_t>(derivative)), low(static_cast<std::size_t>(order));
    for (int k = -400; k < samples; ++k) {
      const double position = x(k) + zero;
      double y = std::floor(position + 0.5) - position;
      for (double& b : before) {
        const double now = y;
        y = 1000 * (y - b);
        b = now;
      }
      for (double& l : low) y = l = (1 - a) * y + a * l;
      if (k >= 0) sum += y * y;
    }
  }
  return std::sqrt(sum / (400.0 * samples));
}

/// A differential: encoder 1 reads joint 1, encoder 2 the difference of the joints.
Transmission differential() {
  Transmission t{{{1e-3}, {2e-3}}, Eigen::Matrix2d()};
  t.coupling << 1, 0, 1, 1;
  return t;
}

TEST(NoiseAlongMotion, AgreesWithAQuantizerBehindADifferential) {
  // Two periods of joint 1 and five of joint 2 in a second: the path closes, so that the average over it is
  // that of a stationary motion.
  const Motion motion{1000, 1, {}, {{0.1, 0, {{0.05, 2, 0.3}}, {}}, {-0.2, 0, {{0.02, 5, 1}}, {}}}, {}};
  const auto joint1 = [](int k) { return 0.1 + 0.05 * std::sin(4 * pi * k / 1000.0 + 0.3); };
  const auto joint2 = [](int k) { return -0.2 + 0.02 * std::sin(10 * pi * k / 1000.0 + 1); };
  for (const auto& [derivative, order] : {std::pair{1, 1}, {1, 3}, {2, 2}}) {
    const Eigen::VectorXd noise =
        noise_along_motion(differential(), motion, autocorrelation(cascade(derivative, order)), 1000);
    const double first = simulated(
        derivative, order, [&](int k) { return joint1(k) / 1e-3; }, 1000);
    const double second = simulated(
        derivative, order, [&](int k) { return (joint2(k) - joint1(k)) / 2e-3; }, 1000);
    EXPECT_NEAR(noise[0] / first, 1, 0.02) << derivative << ' ' << order;
    EXPECT_NEAR(noise[1] / second, 1, 0.02) << derivative << ' ' << order;
  }
}

TEST(NoiseAlongMotion, IsZeroAtRestAndAtIntegerCountsPerSample) {
  const Motion motion{1000, 1, {}, {{0, 0, {}, {}}, {0, 4.0, {}, {}}}, {}};  // 4 rad/s: 2 counts a sample
  const Eigen::VectorXd noise =
      noise_along_motion(differential(), motion, autocorrelation(cascade(1, 2)), 1000);
  EXPECT_NEAR(noise[0], 0, 1e-4);
  EXPECT_NEAR(noise[1], 0, 1e-4);
}

/// A motion much shorter than the filter's memory: the speed is assumed constant before it.
TEST(NoiseAlongMotion, OfAShortMotionIsThatOfItsSpeed) {
  const Autocorrelation memory = autocorrelation(cascade(1, 2));
  for (const double duration : {0.002, 0.005, 0.05, 0.5}) {
    const Motion motion{
        1000, duration, {}, {{0, 0.3, {}, {}}, {0, 4.3, {}, {}}}, {}};  // 0.3 and 2 counts a sample
    const Eigen::VectorXd noise = noise_along_motion(differential(), motion, memory, 1000);
    EXPECT_NEAR(noise[0] / constant_speed_sigma(memory, 0.3), 1, 1e-6) << duration;
    EXPECT_NEAR(noise[1], 0, 1e-3) << duration;
  }
}

TEST(NoiseAlongMotion, OfALongMotionIsEstimatedFromBlocks) {
  Motion motion{1000, 100, {}, {{0, 0, {{0.5, 0.37, 0}}, {}}, {0, 0, {{0.3, 0.53, 0}}, {}}}, {}};
  const Autocorrelation memory = autocorrelation(cascade(1, 2));
  const Eigen::VectorXd whole = noise_along_motion(differential(), motion, memory, 1000);
  motion.duration = 1000;
  const Eigen::VectorXd parts = noise_along_motion(differential(), motion, memory, 1000);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(parts[i] / whole[i], 1, 0.03);
}

}  // namespace
}  // namespace qerr
