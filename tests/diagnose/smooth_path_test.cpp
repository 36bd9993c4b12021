#include "diagnose/record/smooth_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

namespace qerr {
namespace {

/// A known path, recorded with noise at uneven time stamps and rounded to a grid.
struct RecordedPath {
  Eigen::ArrayXd time, path, velocity, recorded;
  double noise = 0;

  template <class Path>
  RecordedPath(std::mt19937& dice, int rows, double rate, double unevenness, double sigma, double grid,
               Path at)
      : time(rows),
        path(rows),
        velocity(rows),
        recorded(rows),
        noise(std::hypot(sigma, grid / std::sqrt(12.0))) {
    std::uniform_real_distribution<double> shift(-unevenness, unevenness);
    std::normal_distribution<double> normal(0, sigma > 0 ? sigma : 1);
    for (int k = 0; k < rows; ++k) {
      time[k] = (k + (k > 0 ? shift(dice) : 0)) / rate;
      const auto [q, v] = at(time[k]);
      path[k] = q;
      velocity[k] = v;
      recorded[k] = grid * std::round((q + (sigma > 0 ? normal(dice) : 0)) / grid);
    }
  }
};

double rms(const Eigen::ArrayXd& x) { return std::sqrt(x.square().mean()); }

std::pair<double, double> two_sines(double t) {
  const double slow = 2 * std::numbers::pi * 0.3, fast = 2 * std::numbers::pi * 1.1;
  return {0.6 * std::sin(slow * t) + 0.1 * std::sin(fast * t),
          0.6 * slow * std::cos(slow * t) + 0.1 * fast * std::cos(fast * t)};
}

/// Forward and backward with a constant acceleration, at rest most of the time.
std::pair<double, double> ramps(double t) {
  const double s = std::fmod(t, 6.0), into = s < 3 ? s - 1.5 : s - 4.5;
  double q = 0, v = 0;
  if (into > 0 && into < 0.2) q = 2.5 * into * into, v = 5 * into;
  if (into >= 0.2 && into < 0.8) q = into - 0.1, v = 1;
  if (into >= 0.8 && into < 1) q = 0.8 - 2.5 * (1 - into) * (1 - into), v = 5 * (1 - into);
  if (into >= 1) q = 0.8;
  return s < 3 ? std::pair{q, v} : std::pair{0.8 - q, -v};
}

TEST(SmoothPath, FindsTheNoiseAtEvenAndUnevenStampsFastAndSlow) {
  std::mt19937 dice(3);
  for (const double rate : {100.0, 1000.0})
    for (const double unevenness : {0.0, 0.3})
      for (const double sigma : {0.0, 1e-6, 1e-5})
        for (const double grid : {1e-7, 1e-5})
          for (const bool rests : {false, true}) {
            const int rows = 1500 + static_cast<int>(dice() % 1000);
            const RecordedPath r(dice, rows, rate, unevenness, sigma, grid, rests ? ramps : two_sines);
            const SmoothPath s = smooth_path(r.time, r.recorded, grid);
            SCOPED_TRACE(std::to_string(rate) + " Hz, " + std::to_string(unevenness) + ", sigma " +
                         std::to_string(sigma * 1e6) + "e-6, grid " + std::to_string(grid * 1e6) + "e-6, " +
                         (rests ? "ramps" : "sines"));
            EXPECT_GT(s.noise, 0.8 * r.noise);
            EXPECT_LT(s.noise, 1.5 * r.noise);
            EXPECT_LT(rms(s.position - r.path), 1.05 * r.noise);
          }
}

TEST(SmoothPath, HalvesTheNoiseOfAFastRecordAndKeepsItsVelocity) {
  std::mt19937 dice(8);
  for (const double unevenness : {0.0, 0.3}) {
    const RecordedPath r(dice, 6000, 1000, unevenness, 1e-5, 1e-7, two_sines);
    const SmoothPath s = smooth_path(r.time, r.recorded, 1e-7);
    EXPECT_LT(rms(s.position - r.path), 0.5 * r.noise);
    EXPECT_LT(rms(s.velocity - r.velocity), 1e-3);
  }
}

TEST(SmoothPath, IsExactOnACubicAtAnyStamps) {
  std::mt19937 dice(5);
  const RecordedPath r(dice, 400, 50, 0.3, 0, 1e-15, [](double t) {
    return std::pair{1 + t * (2 - t * (0.5 - 0.1 * t)), 2 - t + 0.3 * t * t};
  });
  const SmoothPath s = smooth_path(r.time, r.recorded, 0);
  EXPECT_LT((s.position - r.path).abs().maxCoeff(), 1e-10);
  const Eigen::Index inside = r.time.size() - 2;
  EXPECT_LT((s.velocity - r.velocity).segment(1, inside).abs().maxCoeff(), 1e-3);
}

TEST(SmoothPath, AcceptsCoincidentStamps) {
  std::mt19937 dice(6);
  RecordedPath r(dice, 2000, 1000, 0, 1e-6, 1e-9, two_sines);
  for (Eigen::Index k = 1; k < r.time.size(); k += 7) r.time[k] = r.time[k - 1];
  const SmoothPath s = smooth_path(r.time, r.recorded, 1e-9);
  EXPECT_TRUE(s.position.isFinite().all());
  EXPECT_TRUE(s.velocity.isFinite().all());
}

/// A motion that is too fast for its rows: a local cubic would make its velocity some percent too small.
TEST(SmoothPath, HasTheVelocityOfThirteenRowsAPeriod) {
  const double omega = 2 * std::numbers::pi * 3;
  const auto sine = [&](double t) {
    return std::pair{0.05 * std::sin(omega * t + 0.3), 0.05 * omega * std::cos(omega * t + 0.3)};
  };
  std::mt19937 dice(5);
  const RecordedPath r(dice, 1500, 40, 0, 0, 1e-7, sine);
  const SmoothPath s = smooth_path(r.time, r.recorded, 1e-7);
  const Eigen::Index inside = r.time.size() - 10;
  EXPECT_LT(rms((s.velocity - r.velocity).segment(5, inside)), 1e-3 * rms(r.velocity));
}

/// Forth and back at a constant speed.
std::pair<double, double> triangle(double t) {
  const double s = std::fmod(t, 2.0);
  return s < 1 ? std::pair{0.01 * s, 0.01} : std::pair{0.01 * (2 - s), -0.01};
}

TEST(SmoothPath, KeepsTheCornersOfAMotion) {
  std::mt19937 dice(8);
  const RecordedPath r(dice, 8000, 1000, 0, 3e-5, 1e-9, triangle);
  const SmoothPath s = smooth_path(r.time, r.recorded, 1e-9);
  EXPECT_LT(rms(s.position - r.path), 0.35 * r.noise);
  EXPECT_LT((s.position - r.path).abs().maxCoeff(), 4.5 * r.noise);
}

TEST(SmoothPath, OfFewRowsIsAsSmooth) {
  std::mt19937 dice(9);
  for (int i = 0; i < 40; ++i) {
    const RecordedPath r(dice, 600, 1000, 0, 1e-3, 1e-9, two_sines);
    EXPECT_LT(smooth_path(r.time, r.recorded, 1e-9).residual_noise, 0.4 * r.noise);
  }
}

TEST(SmoothPath, InSectionsHasLessNoiseThanInWindows) {
  std::mt19937 dice(10);
  const RecordedPath r(dice, 8000, 1000, 0, 3e-5, 1e-9, triangle);
  const SmoothPath s = smooth_path(r.time, r.recorded, 1e-9);
  EXPECT_LT(rms(sectioned_path(r.time, r.recorded, s.position, s.noise) - r.path), 0.15 * r.noise);
}

TEST(SmoothPath, IsTheSameAtAnInstantFromWhateverRowTheSearchBegins) {
  std::mt19937 dice(6);
  const auto sine = [](double t) { return std::pair{std::sin(3 * t), 3 * std::cos(3 * t)}; };
  const RecordedPath r(dice, 60, 10, 0.3, 0, 1e-7, sine);
  std::uniform_real_distribution<double> anywhere(-1, 7);
  Eigen::Index row = 0;  // of the previous instant
  for (int i = 0; i < 500; ++i) {
    const double instant = i % 9 == 0 ? r.time[i % 60] : anywhere(dice);
    EXPECT_EQ(position_at(r.time, r.path, r.velocity, instant, row),
              position_at(r.time, r.path, r.velocity, instant));
    if (instant < 0.5 || instant > 5.5) continue;  // a cubic of samples 0.1 s apart
    EXPECT_NEAR(position_at(r.time, r.path, r.velocity, instant, row), std::sin(3 * instant), 1e-3);
  }
}

}  // namespace
}  // namespace qerr
