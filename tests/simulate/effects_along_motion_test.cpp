#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "simulate/along_motion.hpp"
#include "support/design_filter.hpp"
#include "support/effect_experiment.hpp"
#include "support/reference_filter.hpp"

// The signals are written down from their definitions, not by the effects' actions.

namespace qerr {
namespace {

using std::numbers::pi;
constexpr double rate = 1000;

/// Two sines, as a motion and as a function of time.
struct TwoSines {
  double center = 0.2, amplitude[2] = {0.6, 0.05}, frequency[2] = {0.4, 1.7}, phase[2] = {0.3, 1.1};

  Motion motion(double seconds) const {
    JointMotion joint{center, 0, {}, {}};
    for (int i : {0, 1}) joint.sines.push_back({amplitude[i], frequency[i], phase[i]});
    return {rate, seconds, {}, {joint}, {}};
  }
  double operator()(double t) const {
    double x = center;
    for (int i : {0, 1}) x += amplitude[i] * std::sin(2 * pi * frequency[i] * t + phase[i]);
    return x;
  }
};

using SampledSignal = std::function<double(int)>;  // of the sample

struct Expected {
  double mean, sigma, peak;
};

/// Every `every`-th sample of a signal through a filter that starts at rest at the first one.
Expected filtered(const Filter* filter, int every, int samples, int settled, const SampledSignal& signal) {
  std::vector<double> out;
  testing::ReferenceFilter reference(filter ? *filter : cascade(0, 1), 1);
  for (int k = 0; k < samples; k += every) {
    Eigen::ArrayXd x = Eigen::ArrayXd::Constant(1, signal(k));
    if (filter && k == 0) reference.settle(x);
    if (filter) reference.step(x);
    if (k >= settled) out.push_back(x[0]);
  }
  Expected e{0, 0, 0};
  for (const double y : out) e.mean += y / static_cast<double>(out.size());
  for (const double y : out) {
    e.sigma += (y - e.mean) * (y - e.mean) / static_cast<double>(out.size());
    e.peak = std::max(e.peak, std::abs(y));
  }
  e.sigma = std::sqrt(e.sigma);
  return e;
}

void expect_moments(const SignalMoments& m, Eigen::Index row, double factor, const Expected& e,
                    double tolerance = 1e-6) {
  EXPECT_NEAR(m.mean[row], factor * e.mean, tolerance * std::abs(factor) * e.peak);
  EXPECT_NEAR(std::sqrt(m.covariance(row, row)), std::abs(factor) * e.sigma,
              tolerance * std::abs(factor) * e.peak);
  EXPECT_NEAR(m.peak[row], std::abs(factor) * e.peak, tolerance * std::abs(factor) * e.peak);
}

/// A revolute joint about z, 0.7 m from the tip, near the angle 0 its error moves the tip along y.
OperationalModel slider() {
  OperationalModel model = testing::one_joint();
  model.chain.independent[0].type = JointType::prismatic;
  model.chain.joints[0].prismatic = true;
  model.chain.joints[0].axis = Eigen::Vector3d::UnitX();
  model.coordinates = {Coordinate::x};
  return model;
}

TEST(EffectsAlongMotion, AreTheSignalsOfTheirDefinitionsBehindEveryFilter) {
  const TwoSines x;
  const int samples = 5000, settled = 1200;
  const double shaft = 10;  // of the encoder in one_joint
  struct Case {
    Effect effect;
    SampledSignal error;
  };
  double side = 0, last = x(0);
  const std::vector<Case> cases{
      {{"latency", "elbow", {{"delay", 2.5e-3}}, {}},
       [&](int k) { return x(k / rate - 2.5e-3) - x(k / rate); }},
      {{"clock_drift", "elbow", {{"rate", 1e-4}}, {}},
       [&](int k) { return x(k / rate * (1 + 1e-4)) - x(k / rate); }},
      {{"scale", "elbow", {{"scale", 2e-3}}, {}}, [&](int k) { return 2e-3 * x(k / rate); }},
      {{"offset", "elbow", {{"offset", 1e-3}}, {}}, [](int) { return 1e-3; }},
      {{"drift", "elbow", {{"amplitude", 1e-3}, {"time_constant", 2}}, {}},
       [](int k) { return 1e-3 * (1 - std::exp(-k / rate / 2)); }},
      {{"transmission_error",
        "elbow",
        {{"amplitude", 1e-3}, {"phase", 0.4}, {"order", 3}},
        {{"shaft", "encoder"}}},
       [&](int k) { return 1e-3 * std::sin(3 * shaft * x(k / rate) + 0.4); }},
      {{"transmission_error", "elbow", {{"amplitude", 1e-3}, {"order", 0.7}}, {{"shaft", "joint"}}},
       [&](int k) { return 1e-3 * std::sin(0.7 * x(k / rate)); }},
      {{"missed_counts", "elbow", {{"counts", 40}, {"time", 2.5}}, {}},
       [&](int k) { return k < 2500 ? 0 : 40 * 2 * pi / 20000; }},
      {{"backlash", "elbow", {{"gap", 2e-3}}, {}},
       [&](int k) {
         if (k == 0) side = 0;
         if (k > 0 && x(k / rate) != last) side = x(k / rate) > last ? 1 : -1;
         last = x(k / rate);
         return 1e-3 * side;
       }},
  };
  const std::vector<Filter> filters = {cascade(1, 2), cascade(0, 2, 10),
                                       design_filter("butterworth", 2, rate, 4, 30),
                                       design_filter("bessel", 1, rate / 2, 3, 8)};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.effect.type);
    const ErrorAlongMotion found =
        effects_along_motion(slider(), {c.effect}, x.motion(samples / rate), filters, settled / rate);
    const Expected unfiltered = filtered(nullptr, 1, samples, settled, c.error);
    expect_moments(found.tip, 0, 1, unfiltered);
    expect_moments(found.joints, 0, 1, unfiltered);
    expect_moments(effect_along_motion(slider(), c.effect, x.motion(samples / rate), settled / rate), 0, 1,
                   unfiltered);
    for (std::size_t f = 0; f < filters.size(); ++f) {
      SCOPED_TRACE("filter " + std::to_string(f));
      // Signals without derivative leave only rounding errors behind a filter.
      const Expected e = filtered(&filters[f], f == 3 ? 2 : 1, samples, settled, [&](int k) {
        // The backlash keeps a state: it is advanced at every sample.
        if (f == 3 && k > 0) c.error(k - 1);
        return c.error(k);
      });
      if (e.peak < 1e-9) {
        EXPECT_LT(found.filtered[f].peak[0], 1e-6);
      } else {
        expect_moments(found.filtered[f], 0, 1, e);
      }
    }
  }
}

/// The derivative of amplitude sin(order shaft x) times half a count, at its largest; the ratio of the shaft
/// is 10.
TEST(EffectsAlongMotion, ChangeWithTheZeroOfTheEncoder) {
  const TwoSines x;
  const Effect ripple{
      "transmission_error", "elbow", {{"amplitude", 1e-3}, {"order", 3}}, {{"shaft", "encoder"}}},
      late{"latency", "elbow", {{"delay", 2e-3}}, {}};
  const double half = 0.5 * slider().transmission.encoders[0].resolution;
  EXPECT_NEAR(change_with_zero(slider(), {ripple}, 0, x.motion(8), 0) / (1e-3 * 3 * 10 * half), 1, 1e-3);
  EXPECT_EQ(change_with_zero(slider(), {late}, 0, x.motion(8), 0), 0);
}

/// The tip of an arm moves on a circle: an error of the angle passes through the exact kinematics.
TEST(EffectsAlongMotion, PassThroughTheKinematicsAlongTheMotion) {
  const TwoSines x;
  const OperationalModel model = testing::one_joint();
  const Filter filter = cascade(1, 2);
  const int samples = 4000, settled = 500;
  const Effect effect{"scale", "elbow", {{"scale", 0.05}}, {}};
  const ErrorAlongMotion found =
      effects_along_motion(model, {effect}, x.motion(samples / rate), {filter}, settled / rate);
  const Eigen::Vector3d axis = model.chain.joints[0].axis;
  for (const Eigen::Index row : {0, 1, 2}) {
    const SampledSignal error = [&](int k) {
      const double q = x(k / rate);
      const auto tip = [&](double angle) -> Eigen::Vector3d {
        return Eigen::AngleAxisd(angle, axis) * model.chain.tip_offset.translation();
      };
      return (tip(1.05 * q) - tip(q))[row];
    };
    const Expected direct = filtered(nullptr, 1, samples, settled, error);
    if (direct.peak < 1e-12) continue;
    expect_moments(found.tip, row, 1, direct, 1e-9);
    expect_moments(found.filtered[0], row, 1, filtered(&filter, 1, samples, settled, error));
  }
}

TEST(EffectsAlongMotion, OfSeveralEffectsAddAsSignals) {
  const TwoSines x;
  const Motion motion = x.motion(4);
  const Effect one{"scale", "elbow", {{"scale", 1e-3}}, {}},
      opposite{"scale", "elbow", {{"scale", -1e-3 / 1.001}}, {}};
  const ErrorAlongMotion both = effects_along_motion(slider(), {one, opposite}, motion, {cascade(1, 2)}, 1);
  EXPECT_LT(both.tip.peak[0], 1e-12);
  EXPECT_LT(both.filtered[0].peak[0], 1e-9);
}

/// A counter that truncates reads half a count too low on average; the model of quantization has the rest.
TEST(EffectsAlongMotion, OfTruncationAreHalfACount) {
  const ErrorAlongMotion found =
      effects_along_motion(slider(), {{"truncation", "elbow", {}, {}}}, TwoSines().motion(2), {}, 0);
  EXPECT_NEAR(found.tip.mean[0], -pi / 20000, 1e-12);
  EXPECT_NEAR(found.tip.covariance(0, 0), 0, 1e-24);
}

}  // namespace
}  // namespace qerr
