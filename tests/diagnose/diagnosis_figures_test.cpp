#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/measured_diagnosis.hpp"
#include "support/one_joint_record.hpp"

/// Every figure of diagnoses of records with one effect each. What is found in random records is tested
/// elsewhere; here, that a change of the inference that keeps the names and moves the figures is seen.
namespace qerr {
namespace {

using testing::expect_as_measured;

constexpr double full_turn = 2 * std::numbers::pi;

/// What the counter of a machine counts, from its path.
using Flawed = std::function<Column(Machine&)>;

/// The link lags behind the motor, whose shaft has the encoder.
Column with_play(Machine& m, double gap) {
  const Column motor = m.path;
  double link = motor[0];
  for (Eigen::Index k = 0; k < motor.size(); ++k)
    m.path[k] = link = std::clamp(link, motor[k] - gap / 2, motor[k] + gap / 2);
  return motor;
}

Column with_added(const Machine& m, const std::function<double(double time, double angle)>& flaw) {
  Column seen = m.path;
  for (Eigen::Index k = 0; k < seen.size(); ++k) seen[k] += flaw(m.time[k], m.path[k]);
  return seen;
}

TEST(DiagnosisFigures, OfOneJointAreAsMeasured) {
  const std::vector<std::pair<const char*, Flawed>> records{
      {"clean", [](Machine& m) { return m.path; }},
      {"play", [](Machine& m) { return with_play(m, 5 * m.resolution); }},
      {"delay", [](Machine& m) { return m.along(m.time - 2.4 / m.rate); }},
      {"offset", [](Machine& m) { return Column(m.path + 0.8 * m.resolution); }},
      {"scale", [](Machine& m) { return Column(m.path * (1 + 6 * m.resolution)); }},
      {"eccentric disc",
       [](Machine& m) {
         const double size = 3 * m.resolution;
         return with_added(
             m, [=](double, double q) { return std::atan2(size * std::sin(q), 1 - size * std::cos(q)); });
       }},
      {"second order",
       [](Machine& m) {
         const double size = 2 * m.resolution;
         return with_added(m, [=](double, double q) { return size * std::cos(2 * q + 0.4); });
       }},
      {"noise",
       [](Machine& m) {
         Column seen = m.path;
         for (double& x : seen) x += 0.7 * m.resolution * m.normal();
         return seen;
       }},
      {"jitter",
       [](Machine& m) {
         Column late = m.time;
         for (double& t : late) t += 0.4 / m.rate * m.normal();
         return m.along(late);
       }},
      {"lost counts",
       [](Machine& m) {
         const double size = 4 * m.resolution, at = 0.55 * m.rows / m.rate;
         return with_added(m, [=](double t, double) { return t > at ? -size : 0; });
       }},
      {"line",
       [](Machine& m) {
         const double size = 1.5 * m.resolution;
         return with_added(m, [=](double t, double) { return size * std::sin(full_turn * 17.3 * t); });
       }},
      {"drift",
       [](Machine& m) {
         const double size = 5 * m.resolution, end = m.rows / m.rate;
         return with_added(m, [=](double t, double) { return size * std::pow(t / end, 3); });
       }},
      {"warming",
       [](Machine& m) {
         const double size = 6 * m.resolution, constant = 0.25 * m.rows / m.rate;
         return with_added(m, [=](double t, double) { return size * (1 - std::exp(-t / constant)); });
       }},
      {"noise and a noisy reference",
       [](Machine& m) {
         Column seen = m.path;
         for (double& x : seen) x += 0.6 * m.resolution * m.normal();
         m.noise = 0.5 * m.resolution;
         return seen;
       }},
      {"bump",
       [](Machine& m) {
         const double size = 6 * m.resolution, centre = m.centre;
         return with_added(
             m, [=](double, double q) { return size * std::exp(-std::pow((q - centre) / 0.05, 2)); });
       }},
      {"play and disc",
       [](Machine& m) {
         const Column motor = with_play(m, 4 * m.resolution);
         return Column(motor + 3 * m.resolution * motor.sin());
       }},
  };
  for (const auto& [what, flawed] : records)
    for (unsigned seed = 1; seed <= 2; ++seed) {
      Machine m(40 * seed + 1);
      const Column seen = flawed(m);
      expect_as_measured(what + (' ' + std::to_string(seed)),
                         diagnose(model_of(m), {}, {}, log_of(m, m.counted(seen))));
    }
}

/// The counter of an encoder whose states are alternately wide and narrow: every second edge is displaced.
Column counted_unevenly(const Machine& m, double displacement) {
  return m.path.unaryExpr([&](double x) {
    const double count = std::ceil(x / m.resolution - 0.5);
    // The edge below `count` is at count - 1/2, the one above at count + 1/2; odd ones are displaced.
    const auto edge = [&](double below) {
      return (std::fmod(std::abs(below), 2) == 1 ? below + displacement : below) + 0.5;
    };
    if (x / m.resolution > edge(count)) return count + 1;
    return x / m.resolution > edge(count - 1) ? count : count - 1;
  });
}

/// To the upper neighbour of two, so that the error is the same on both sides of zero.
Column rounded(const Column& x) { return (x + 0.5).floor(); }

TEST(DiagnosisFigures, OfFaultyCountersAreAsMeasured) {
  const std::vector<std::pair<const char*, std::function<Column(Machine&)>>> counters{
      {"uneven states", [](Machine& m) { return counted_unevenly(m, 0.3); }},
      {"uneven states and noise",
       [](Machine& m) {
         for (double& x : m.path) x += 0.4 * m.resolution * m.normal();
         return counted_unevenly(m, 0.25);
       }},
      {"rollover",
       [](Machine& m) {
         Column counts = m.counted(m.path);
         counts -= 1024 * (counts / 1024).floor();
         return counts;
       }},
      {"every fourth count", [](Machine& m) { return Column(4 * rounded(m.counted(m.path) / 4)); }},
      {"other decoding", [](Machine& m) { return rounded(0.5 * m.counted(m.path)); }},
      {"held",
       [](Machine& m) {
         Column counts = m.counted(m.path);
         for (Eigen::Index k = 0; k < counts.size(); ++k) counts[k] = counts[k - k % 4];
         return counts;
       }},
      {"stuck for a while",
       [](Machine& m) {
         Column counts = m.counted(m.path);
         counts.segment(m.rows / 3, m.rows / 8).setConstant(counts[m.rows / 3]);
         return counts;
       }},
      {"wrong sign", [](Machine& m) { return Column(-m.counted(m.path)); }},
  };
  for (const auto& [what, counted] : counters)
    for (unsigned seed = 1; seed <= 2; ++seed) {
      Machine m(60 * seed + 7);
      const Machine true_path = m;
      const Column counts = counted(m);
      m.path = true_path.path;
      expect_as_measured(what + (' ' + std::to_string(seed)),
                         diagnose(model_of(m), {}, {}, log_of(m, counts)));
    }
}

/// With the controller's velocity, and as a table without time.
TEST(DiagnosisFigures, OfOtherColumnsAreAsMeasured) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Machine m(80 * seed + 3);
    const Column counts = m.counted(m.path + 3 * m.resolution * (m.path + 0.3).sin());
    const Filter filter = first_order(m.rate, 1, 0.03 * m.rate);
    const Column velocity =
        controller_velocity(m, counts * m.resolution, 1, (seed == 1 ? 0.03 : 0.05) * m.rate);
    expect_as_measured("velocity " + std::to_string(seed),
                       diagnose(model_of(m), {filter}, {},
                                log_of({{LogSignal::time, m.time},
                                        {LogSignal::counts, counts, 0},
                                        {LogSignal::reference, m.reference()},
                                        {LogSignal::velocity, velocity, 6}})));
    expect_as_measured(
        "table " + std::to_string(seed),
        diagnose(model_of(m), {}, {},
                 log_of({{LogSignal::counts, counts, 0}, {LogSignal::reference, m.reference()}})));
  }
}

}  // namespace
}  // namespace qerr
