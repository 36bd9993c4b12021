#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "bound/noise_in_motion.hpp"
#include "qerr/filter/norms.hpp"
#include "simulate/along_motion.hpp"
#include "support/design_filter.hpp"
#include "support/reference_filter.hpp"
#include "support/sample_filters.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

/// Position at time t of moves with trapezoidal velocity between 0 and `to`, `dwell` at both ends.
double trapezoids(double to, double velocity, double acceleration, double dwell, double t) {
  const double ramp = velocity / acceleration, cruise = to / velocity - ramp, move = 2 * ramp + cruise;
  const auto risen = [&](double s) {
    if (s >= move) return to;
    if (s < ramp) return 0.5 * acceleration * s * s;
    if (s < ramp + cruise) return velocity * (s - 0.5 * ramp);
    return to - 0.5 * acceleration * (move - s) * (move - s);
  };
  const double phase = std::fmod(t, 2 * (move + dwell));
  return phase < move + dwell ? risen(phase) : to - risen(phase - move - dwell);
}

/// Root mean square of the filtered error of a quantizer along x(t) [counts], over positions of its zero, one
/// in each of equal parts of a count, with the filter at rest at the first error.
template <class Path>
double simulated(const Filter& filter, double duration, double settling, Path x, Eigen::Index zeros = 2000) {
  const auto samples = static_cast<int>(std::floor(duration * filter.sample_rate + 0.5));
  const double first = std::ceil(settling * filter.sample_rate);
  testing::ReferenceFilter reference(filter, zeros);
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> uniform;
  Eigen::ArrayXd zero(zeros);
  for (Eigen::Index k = 0; k < zeros; ++k)
    zero[k] = (static_cast<double>(k) + uniform(engine)) / static_cast<double>(zeros);
  double sum = 0;
  for (int n = 0; n < samples; ++n) {
    const Eigen::ArrayXd position = zero + x(n / filter.sample_rate);
    Eigen::ArrayXd error = (position + 0.5).floor() - position;
    if (n == 0) reference.settle(error);
    reference.step(error);
    if (n >= first) sum += error.square().sum();
  }
  return std::sqrt(sum / (static_cast<double>(zeros) * (samples - first)));
}

OperationalModel with(const Transmission& transmission) { return {{}, transmission, {}}; }

OperationalModel single() { return with({{{1e-3}}, Eigen::MatrixXd::Identity(1, 1)}); }

/// A differential: encoder 1 reads joint 1, encoder 2 the difference of the joints.
OperationalModel differential() {
  Transmission t{{{1e-3}, {2e-3}}, Eigen::Matrix2d()};
  t.coupling = (Eigen::Matrix2d() << 1, 0, 1, 1).finished();
  return with(t);
}

struct Case {
  const char* name;
  JointMotion joint;
  double duration, settling;
  std::function<double(double)> position;  // [rad]
  Eigen::Index zeros = 2000;
};

std::vector<Case> cases() {
  return {{"short trapezoids",
           {0, 0, {}, {{0.05, 0.4, 4, 0, 0.1}, {0, 0.4, 4, 0, 0.1}}},
           0.5,
           0,
           [](double t) { return trapezoids(0.05, 0.4, 4, 0.1, t); }},
          {"long trapezoids",
           {0, 0, {}, {{0.3, 0.5, 3, 0, 0.3}, {0, 0.5, 3, 0, 0.3}}},
           4,
           0.5,
           [](double t) { return trapezoids(0.3, 0.5, 3, 0.3, t); }},
          {"sines",
           {0.02, 0, {{0.1, 0.7, 0}, {0.05, 2.3, 1}}, {}},
           2,
           0.3,
           [](double t) {
             return 0.02 + 0.1 * std::sin(2 * pi * 0.7 * t) + 0.05 * std::sin(2 * pi * 2.3 * t + 1);
           }},
          {"creeping", {0.0003, 0.002, {}, {}}, 1, 0.1, [](double t) { return 0.0003 + 0.002 * t; }},
          {"creeping over 1.4 counts",
           {0.0003, 0.0014, {}, {}},
           1,
           0.1,
           [](double t) { return 0.0003 + 0.0014 * t; }},
          {"a tremor of 0.04 counts",
           {0.1, 0, {{2e-5, 8, 0.3}}, {}},
           1,
           0.1,
           [](double t) { return 0.1 + 2e-5 * std::sin(16 * pi * t + 0.3); },
           10000},  // few of them have an edge in the tremor
          {"one move of 0.3 counts",
           {0, 0, {}, {{3e-4, 1e-3, 0.01, 0, 0.1}, {0, 1e-3, 0.01, 0, 10}}},
           0.5,
           0,
           [](double t) { return trapezoids(3e-4, 1e-3, 0.01, 0.1, std::min(t, 0.6)); }},
          {"2.25 counts a sample", {0, 2.25, {}, {}}, 1, 0.1, [](double t) { return 2.25 * t; }},
          {"a third of a count a sample", {0, 1 / 3.0, {}, {}}, 1, 0, [](double t) { return t / 3; }},
          {"five samples", {0, 0.7, {}, {}}, 0.005, 0, [](double t) { return 0.7 * t; }}};
}

TEST(SigmaAlongMotion, IsThatOfSimulatedZeros) {
  const std::vector<Filter> filters = {cascade(1, 1), cascade(1, 3, 5), cascade(0, 2, 20),
                                       design_filter("butterworth", 2, 1000, 4, 30),
                                       design_filter("bessel", 1, 500, 3, 40)};
  for (const Case& c : cases())
    for (std::size_t f = 0; f < filters.size(); ++f) {
      const Motion motion{1000, c.duration, {}, {c.joint}, {}};
      const auto sigma = sigma_along_motion(single(), {}, motion, filters[f], c.settling);
      ASSERT_TRUE(sigma);
      const double expected = simulated(
          filters[f], c.duration, c.settling, [&](double t) { return c.position(t) / 1e-3; }, c.zeros);
      EXPECT_NEAR((*sigma)[0] / expected, 1, 0.002) << c.name << ", filter " << f;
    }
}

TEST(SigmaAlongMotion, HoldsForEveryFamilyOfFilters) {
  const Case c = cases()[1];
  const Motion motion{1000, 1, {}, {c.joint}, {}};
  for (const SampleFilter& sample : sample_filters()) {
    const Filter filter = designed(sample, 1);
    const auto sigma = sigma_along_motion(single(), {}, motion, filter, 0);
    const double expected = simulated(filter, 1, 0, [&](double t) { return c.position(t) / 1e-3; });
    EXPECT_NEAR((*sigma)[0] / expected, 1, 0.002) << sample.family;
  }
}

TEST(SigmaAlongMotion, OfEncodersBehindADifferentialIsOfTheirOwnPositions) {
  const Motion motion{1000, 1, {}, {{0.1, 0, {{0.05, 2, 0.3}}, {}}, {-0.2, 0, {{0.02, 5, 1}}, {}}}, {}};
  const auto joint1 = [](double t) { return 0.1 + 0.05 * std::sin(4 * pi * t + 0.3); };
  const auto joint2 = [](double t) { return -0.2 + 0.02 * std::sin(10 * pi * t + 1); };
  for (const auto& [derivative, order] : {std::pair{1, 1}, {1, 3}, {2, 2}}) {
    const Filter filter = cascade(derivative, order);
    const auto sigma = sigma_along_motion(differential(), {}, motion, filter, 0.1);
    const double first = simulated(filter, 1, 0.1, [&](double t) { return joint1(t) / 1e-3; });
    const double second = simulated(filter, 1, 0.1, [&](double t) { return (joint2(t) - joint1(t)) / 2e-3; });
    EXPECT_NEAR((*sigma)[0] / first, 1, 0.002) << derivative << ' ' << order;
    EXPECT_NEAR((*sigma)[1] / second, 1, 0.002) << derivative << ' ' << order;
  }
}

TEST(SigmaAlongMotion, IsZeroAtRestAndAtWholeCountsPerSample) {
  const Motion motion{1000, 1, {}, {{0, 0, {}, {}}, {0, 4.0, {}, {}}}, {}};  // 4 rad/s: 2 counts a sample
  const auto sigma = sigma_along_motion(differential(), {}, motion, cascade(1, 2), 0);
  EXPECT_NEAR((*sigma)[0], 0, 1e-9);
  EXPECT_NEAR((*sigma)[1], 0, 1e-9);
}

/// A slider with an encoder of 1 mm and 4 counts a line.
OperationalModel one_slider() {
  OperationalModel model = single();
  ChainJoint joint;
  joint.name = "j";
  model.chain.joints.push_back(joint);
  model.chain.independent.push_back({"j", JointType::prismatic, {}, true});
  return model;
}

Effect effect_of(const char* type, const char* parameter, double value) {
  return {type, "j", {{parameter, value}}, {}};
}

/// Root mean square over 2048 zeros of the filtered D([x + u]) - u less its mean over u; `decode` is D.
template <class Path, class Decode>
double simulated_behind(Decode decode, const Filter& filter, double duration, Path x) {
  constexpr Eigen::Index zeros = 2048;
  testing::ReferenceFilter reference(filter, zeros);
  const Eigen::ArrayXd zero = (Eigen::ArrayXd::LinSpaced(zeros, 0, zeros - 1) + 0.5) / zeros - 0.5;
  const auto samples = static_cast<int>(std::floor(duration * filter.sample_rate + 0.5));
  double sum = 0;
  for (int n = 0; n < samples; ++n) {
    Eigen::ArrayXd error = (zero + x(n / filter.sample_rate) + 0.5).floor().unaryExpr(decode) - zero;
    error -= error.mean();
    if (n == 0) reference.settle(error);
    reference.step(error);
    sum += error.square().sum();
  }
  return std::sqrt(sum / (static_cast<double>(zeros) * samples));
}

TEST(SigmaAlongMotion, BehindADecoderIsThatOfTheDecodedCounts) {
  const OperationalModel model = one_slider();
  const auto slow = [](double t) { return 0.3 + 13.3 * t; };
  const Motion motion{1000, 2, {}, {{0.3e-3, 13.3e-3, {}, {}}}, {}};
  for (const double factor : {1.5, 0.25, -1.0})
    for (const Filter& filter : {cascade(1, 1), cascade(2, 3, 20)}) {
      Effect effect;
      effect.type = "decoding";
      effect.joint = "j";
      effect.numbers["factor"] = factor;
      const auto sigma = sigma_along_motion(model, {effect}, motion, filter, 0);
      const auto decode = [&](double count) { return std::floor(factor * count + 0.5); };
      EXPECT_NEAR((*sigma)[0] / simulated_behind(decode, filter, 2, slow), 1, 0.002) << factor;
    }
}

/// The sum over the harmonics of the rounding error; see `sigma_along_motion`.
TEST(SigmaAlongMotion, WithNoiseIsThatOfEveryHarmonic) {
  for (const double s : {0.02, 0.25, 0.8})
    for (const double v : {0.0, 0.013, 2.37})
      for (const Filter& filter :
           {cascade(1, 2), cascade(0, 1, 20), design_filter("butterworth", 2, 1000, 4, 30)}) {
        const double square = std::pow(h2_norm(filter), 2);
        double sum = s * s * square;
        constexpr int most = 4000;
        for (int k = 1; k <= most; ++k) {
          const double w = std::exp(-4 * pi * pi * k * k * s * s);
          const double power = std::norm(response(filter, std::remainder(k * v, 1.0) * filter.sample_rate));
          sum += (w * power + (1 - w) * square) / (2 * pi * pi * k * k);
        }
        sum += square / (2 * pi * pi * (most + 0.5));
        const Motion motion{1000, 2, {}, {{0.3e-3, v, {}, {}}}, {}};
        const auto sigma =
            sigma_along_motion(one_slider(), {effect_of("noise", "sigma", s * 1e-3)}, motion, filter, 1);
        EXPECT_NEAR((*sigma)[0] / std::sqrt(sum), 1, 0.003) << s << ' ' << v << ' ' << filter.derivative;
      }
}

/// Jitter at a constant speed is noise of the distance covered.
TEST(SigmaAlongMotion, WithJitterIsThatWithNoise) {
  const Motion motion{1000, 2, {}, {{0.3e-3, 0.37, {}, {}}}, {}};
  const Filter filter = cascade(1, 2);
  const auto jitter = sigma_along_motion(one_slider(), {effect_of("timing_jitter", "sigma", 1e-3)}, motion,
                                         filter, 0.2),
             noise = sigma_along_motion(one_slider(), {effect_of("noise", "sigma", 0.37e-3)}, motion, filter,
                                        0.2);
  EXPECT_NEAR((*jitter)[0] / (*noise)[0], 1, 0.005);
}

TEST(SigmaAlongMotion, OfUnequalStatesIsThatOfTheirEdges) {
  for (const double v : {0.0113, 0.37, 0.5}) {
    const double phase = -0.7, shift = phase / (2 * pi) * 4;
    const Filter filter = design_filter("butterworth", 2, 1000, 4, 30);
    constexpr Eigen::Index zeros = 2000;
    testing::ReferenceFilter reference(filter, zeros);
    // Zeros over a line, which has edges at 0, 1 + shift, 2, ...
    const Eigen::ArrayXd zero = (Eigen::ArrayXd::LinSpaced(zeros, 0, zeros - 1) + 0.37) * (4.0 / zeros);
    double sum = 0;
    for (int n = 0; n < 2000; ++n) {
      const Eigen::ArrayXd position = zero + n * v, base = 2 * (position / 2).floor();
      Eigen::ArrayXd error = base + (position - base >= 1 + shift).cast<double>() - position;
      if (n == 0) reference.settle(error);
      reference.step(error);
      if (n >= 200) sum += error.square().sum();
    }
    const Motion motion{1000, 2, {}, {{0.3e-3, v, {}, {}}}, {}};
    const auto sigma =
        sigma_along_motion(one_slider(), {effect_of("state_width", "phase", phase)}, motion, filter, 0.2);
    EXPECT_NEAR((*sigma)[0] / std::sqrt(sum / (zeros * 1800.0)), 1, 0.003) << v;
  }
}

/// Ten periods of 100 samples: few different positions within a count.
TEST(SigmaAlongMotion, HoldsForSinesOfFewSamples) {
  for (const double cycles : {0.01, 0.02}) {
    const Filter filter = design_filter("butterworth", 2, 1000, 4, 30);
    const Motion motion{1000, 1, {}, {{0, 0, {{0.9, cycles * 1000, 0}}, {}}}, {}};
    const double expected =
        simulated(filter, 1, 0, [&](double t) { return 900 * std::sin(2 * pi * cycles * 1000 * t); });
    EXPECT_NEAR((*sigma_along_motion(single(), {}, motion, filter, 0))[0] / expected, 1, 0.002) << cycles;
  }
}

TEST(SigmaAlongMotion, OfALongSineIsThatOfItsSpectrum) {
  const Filter filter = cascade(1, 2);
  const Motion motion{1000, 40, {}, {{0, 0, {{0.0403, 3.13, 0}}, {}}}, {}};
  const auto sigma = sigma_along_motion(single(), {}, motion, filter, 0.2);
  EXPECT_NEAR((*sigma)[0] / sine_sigma(autocorrelation(filter), 40.3, 0.00313), 1, 1e-3);
}

TEST(SigmaAlongMotion, IsEmptyForARecordThatIsTooLong) {
  const Motion motion{1000, 1e6, {}, {{0, 0.1, {}, {}}}, {}};
  EXPECT_FALSE(sigma_along_motion(single(), {}, motion, cascade(1, 2), 0));
}

Travel moved(double from, double to, double length) { return {from, to, from, length}; }

TEST(ZerosOfSimulation, AreMoreForMotionsThatPassFewCounts) {
  EXPECT_EQ(zeros_of_simulation({moved(0, 1e5, 1e5)}, 100000), 20u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 1000, 1000)}, 50000), 131u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 1000, 1000), moved(0, 3, 3)}, 50000), 256u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 0.5, 0.5)}, 50000), 256u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 100, 100)}, 1 << 24), 16u) << "a long motion";
}

TEST(ZerosOfSimulation, AreNoneIfAnEncoderThatMovesCrossesTooFewEdges) {
  EXPECT_EQ(zeros_of_simulation({moved(0, 0.2, 0.2)}, 1000), 0u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 1e5, 1e5), moved(3.1, 3.3, 50)}, 1000), 0u);
  EXPECT_EQ(zeros_of_simulation({moved(0, 1e5, 1e5), moved(3.1, 3.1, 0)}, 100000), 20u)
      << "an encoder at rest";
}

}  // namespace
}  // namespace qerr
