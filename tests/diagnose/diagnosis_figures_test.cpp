#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/measured.hpp"
#include "support/one_joint_record.hpp"
#include "support/tracked_arm.hpp"

/// Every figure of diagnoses of records with one effect each. What is found in random records is tested
/// elsewhere; here, that a change of the inference that keeps the names and moves the figures is seen.
namespace qerr {
namespace {

using testing::Dice;
using testing::Measured;

constexpr double full_turn = 2 * std::numbers::pi;

/// The verdict and the names of all that was found.
std::string said(const Diagnosis& d) {
  std::string text(name(d.verdict));
  for (const Cause& c : d.causes) text += " + " + c.effect.type + " at " + c.effect.joint;
  for (const AlternativeCause& a : d.alternatives)
    text += " or " + a.effect + " at " + a.joint + " for " + a.instead_of;
  for (const Unidentified& u : d.unexplained) text += " + unexplained at " + u.joint + ": " + u.what;
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

/// Compares all figures; the tolerance is that of the fits' last steps, which may differ between compilers.
void expect_as_measured(const std::string& record, const Diagnosis& d) {
  static const Measured measured("diagnoses.csv", 1e-3);
  std::map<std::string, int> met;  // two parts of a residual may have one name
  const auto expect = [&](const std::string& what, double value) {
    const int times = ++met[what];
    measured.expect(record + ',' + what + (times > 1 ? " no " + std::to_string(times) : ""), value);
  };
  const auto expect_gain = [&](const std::string& of, const Gain& g) {
    expect(of + " rms before", g.rms_before);
    expect(of + " rms after", g.rms_after);
    expect(of + " lower ratio", g.lower);
    expect(of + " upper ratio", g.upper);
    expect(of + " sigma ratio", g.sigma_ratio);
    expect(of + " log score", g.log_score);
    expect(of + " coverage", g.coverage);
  };
  expect(said(d), static_cast<double>(d.causes.size()));
  for (const Cause& c : d.causes) {
    for (const FoundParameter& p : c.parameters) {
      expect(c.effect.type + ' ' + p.name, p.value);
      expect(c.effect.type + ' ' + p.name + " half width", 0.5 * (p.upper - p.lower));
    }
    expect(c.effect.type + " log p", std::log(std::max(c.p_value, 1e-300)));
    expect(c.effect.type + " rms", c.rms);
    expect(c.effect.type + " rms without", c.rms_without);
    expect_gain(c.effect.type, c.gain);
  }
  for (const Unidentified& u : d.unexplained) {
    expect(u.what + " amplitude", u.amplitude);
    if (u.order) expect(u.what + " order", *u.order);
    if (u.frequency) expect(u.what + " frequency", *u.frequency);
    for (const auto& [figure, value] : u.figures) expect(u.what + ' ' + figure, value);
  }
  for (const Visible& v : d.visible) expect("visible " + v.effect + " at " + v.joint, v.smallest);
  expect_gain("all", d.gain);
  measured.expect_all_met(record + ',');
}

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

TEST(DiagnosisFigures, OfATrackedTipAreAsMeasured) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Dice dice(700 + seed);
    const std::size_t joints = 2 + seed % 3;
    const testing::Arm arm = testing::random_arm(dice, joints);
    testing::Arm built = arm;
    testing::Record r =
        seed % 2 == 0 ? testing::poses(dice, joints, 200) : testing::motion(dice, joints, 1500);
    r.with_references = seed % 4 == 1;
    const double step = 2e-4;
    switch (seed % 5) {
      case 0:
        built.place[1].y() += 4e-4;
        break;
      case 1:
        r.additions.row(0).setConstant(4 * step);
        break;
      case 2:
        r.additions.row(1) = 5 * step * r.joints.row(1);
        break;
      case 3:
        built.axis[1] = testing::rotation(Eigen::Vector3d::UnitX(), 2e-3) * built.axis[1];
        break;
      default:
        built.tool.x() += 3e-4;
        built.place[0].z() -= 5e-4;
    }
    const std::vector<double> resolution(joints, step);
    const Log log = testing::log_of(dice, built, r, resolution, 1e-5);
    expect_as_measured("tip " + std::to_string(seed), diagnose(arm.model(resolution), {}, {}, log));
  }
}

}  // namespace
}  // namespace qerr
