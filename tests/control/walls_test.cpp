#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "control/control.hpp"

namespace qerr {
namespace {

/// One axis, or several: joints that feel the wall by g.
struct WallAxes {
  Control control;
  Eigen::VectorXd g, counts;

  WallLimit limit() const {
    return wall_limit(control, g, Eigen::MatrixXd::Identity(g.size(), g.size()), counts);
  }
};

WallAxes one_wall_axis(double damping, double friction, double count, double delay) {
  WallAxes a;
  a.control.sample_rate = 1000;
  a.control.delay = delay / 1000;
  JointController j;
  j.damping = damping;
  j.friction = friction;
  a.control.joints = {j};
  a.g = Eigen::VectorXd::Ones(1);
  a.counts = Eigen::VectorXd::Constant(1, count);
  return a;
}

/// A motion of the hand between the samples: straight from point to point.
using HandMotion = std::vector<Eigen::VectorXd>;

/// Energy that the hand puts in along a closed motion [J]: against the wall's held force, viscous damping and
/// Coulomb friction; inertia gives back what it takes. @param points  at multiples of a 1/`fine` of a sample
double hand_energy(const WallAxes& a, double stiffness, const HandMotion& points, int fine) {
  const double t = 1 / (a.control.sample_rate * fine);
  const auto delay = static_cast<int>(std::lround(a.control.samples_of_delay(0) * fine));
  double sum = 0;
  for (int k = 0; k + 1 < static_cast<int>(points.size()); ++k) {
    const int late = k - delay, sample = late < 0 ? 0 : late / fine * fine;
    double reading = 0;
    for (Eigen::Index j = 0; j < a.g.size(); ++j)
      reading +=
          a.g[j] * a.counts[j] * std::floor(points[static_cast<std::size_t>(sample)][j] / a.counts[j] + 0.5);
    const Eigen::VectorXd step =
        points[static_cast<std::size_t>(k) + 1] - points[static_cast<std::size_t>(k)];
    sum += stiffness * reading * a.g.dot(step);
    for (Eigen::Index j = 0; j < step.size(); ++j) {
      const JointController& c = a.control.joints[static_cast<std::size_t>(j)];
      sum += *c.damping * step[j] * step[j] / t + *c.friction * std::abs(step[j]);
    }
  }
  return sum;
}

Eigen::VectorXd place_at(double x) { return Eigen::VectorXd::Constant(1, x); }

/// Random hand motions that return to their start inside the wall.
HandMotion random_hand(std::mt19937& rng, Eigen::Index joints, double size, int fine) {
  std::uniform_real_distribution<double> u(-1, 1);
  HandMotion m(static_cast<std::size_t>(200 * fine) + 1, Eigen::VectorXd::Zero(joints));
  for (Eigen::Index j = 0; j < joints; ++j) {
    const double a = size * u(rng), b = size * u(rng) / 4, f = 2 + 40 * std::abs(u(rng)),
                 g = 3 + 80 * std::abs(u(rng));
    for (std::size_t k = 0; k < m.size(); ++k) {
      const double s = static_cast<double>(k) / static_cast<double>(m.size() - 1);
      m[k][j] = 2 * size + a * std::sin(M_PI * std::floor(f) * s) + b * std::sin(M_PI * std::floor(g) * s);
    }
  }
  return m;
}

TEST(Wall, GivesNoEnergyBelowItsLimit) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(0.1, 1);
  constexpr int fine = 8;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Index joints = 1 + i % 3;
    WallAxes a = one_wall_axis(0, 0, 1, i % 4 == 0 ? 0 : i % 4 == 1 ? 1 : 0.5);
    a.g.resize(joints);
    a.counts.resize(joints);
    a.control.joints.assign(static_cast<std::size_t>(joints), {});
    for (Eigen::Index j = 0; j < joints; ++j) {
      a.control.joints[static_cast<std::size_t>(j)].damping = u(rng);
      a.control.joints[static_cast<std::size_t>(j)].friction = 0.2 * u(rng);
      a.g[j] = u(rng) * (j == 1 ? -1 : 1);
      a.counts[j] = 1e-3 * u(rng);
    }
    const double stiffness = 0.99 * a.limit().stiffness(), size = 1e-3 * std::pow(10, 3 * u(rng) - 1);
    const HandMotion m = random_hand(rng, joints, size, fine);
    EXPECT_GE(hand_energy(a, stiffness, m, fine), -1e-12) << i;
  }
}

TEST(Wall, CountsGiveEnergyAboveTheirLimit) {
  for (const double delay : {0.0, 1.0, 2.0}) {
    constexpr int fine = 4;
    const WallAxes a = one_wall_axis(5, 0.3, 1e-3, delay);
    ASSERT_TRUE(a.limit().by_quantization());
    const double edge = 4.5e-3, d = 1e-5;
    // Up within a sample across the edge, wait until the force has followed, and down; wait again.
    HandMotion m;
    const int wait = static_cast<int>(delay + 2) * fine;
    const auto stay = [&](double x, int steps) {
      for (int k = 0; k < steps; ++k) m.push_back(place_at(x));
    };
    stay(edge - d / 2, wait + 1);
    for (int cycle = 0; cycle < 3; ++cycle) {
      stay(edge + d / 2, wait);
      stay(edge - d / 2, wait);
    }
    for (const double factor : {0.99, 1.3}) {
      const double found = hand_energy(a, factor * a.limit().stiffness(), m, fine);
      // The steps are sudden here: their viscous loss is of second order in d.
      const double viscous = 6 * 5 * d * d * fine * 1000;
      EXPECT_NEAR(found, 3 * (2 * 0.3 - factor * a.limit().stiffness() * 1e-3) * d + viscous, 1e-12);
      EXPECT_EQ(found - viscous<0, factor> 1) << factor << ' ' << delay;
    }
  }
}

TEST(Wall, SamplingGivesEnergyAboveItsLimit) {
  for (const double delay : {0.0, 1.0, 2.0}) {
    constexpr int fine = 32, ramp = 40;
    const WallAxes a = one_wall_axis(0.5, 1e-4, 1e-9, delay);
    ASSERT_FALSE(a.limit().by_quantization());
    HandMotion m;
    double x = 1;
    // Back and forth at a constant speed, turning at samples.
    for (int k = 0; k <= 2 * 4 * ramp * fine; ++k) {
      m.push_back(place_at(x));
      x += (k / (ramp * fine)) % 2 == 0 ? 1e-3 / fine : -1e-3 / fine;
    }
    EXPECT_GT(hand_energy(a, 0.99 * a.limit().stiffness(), m, fine), 0) << delay;
    EXPECT_LT(hand_energy(a, 1.3 * a.limit().stiffness(), m, fine), 0) << delay;
  }
}

TEST(Wall, SeveralJointsGiveEnergyAtRestOfTheClock) {
  WallAxes a = one_wall_axis(1e3, 0, 1e-3, 0);
  a.g = Eigen::Vector2d(0.7, 0.4);
  a.counts = Eigen::Vector2d(1e-3, 2e-3);
  a.control.joints.assign(2, a.control.joints[0]);
  a.control.joints[0].friction = 0.1;
  a.control.joints[1].friction = 10;
  // Joint 1 moves by D within its count; then joint 2 crosses an edge; joint 1 moves back; joint 2, too.
  const double limit_of_round = 2 * 0.1 / (0.7 * 0.4 * 2e-3), d = 0.8e-3, e = 1e-9;
  EXPECT_LE(a.limit().quantization, limit_of_round) << "sufficient";
  const auto round = [&](double stiffness) {
    HandMotion m;
    for (const auto& [x, y] : {std::pair{-d / 2, 0.001 - e},
                               {d / 2, 0.001 - e},
                               {d / 2, 0.001 + e},
                               {-d / 2, 0.001 + e},
                               {-d / 2, 0.001 - e}})
      for (int k = 0; k < 2; ++k) m.push_back(Eigen::Vector2d(x, y));
    double viscous = 0;
    for (std::size_t k = 0; k + 1 < m.size(); ++k) viscous += 1e3 * (m[k + 1] - m[k]).squaredNorm() * 1000;
    return hand_energy(a, stiffness, m, 1) - viscous;  // however slow
  };
  EXPECT_LT(round(1.3 * limit_of_round), 0);
  EXPECT_GT(round(0.9 * limit_of_round), 0);
}

TEST(Wall, OneAxisHasTheLimitsOfAbbottAndOkamura) {
  const WallLimit l = one_wall_axis(2, 0.5, 1e-4, 0).limit();
  EXPECT_DOUBLE_EQ(l.sampling, 2 * 2 * 1000);
  EXPECT_DOUBLE_EQ(l.quantization, 2 * 0.5 / 1e-4);
}

}  // namespace
}  // namespace qerr
