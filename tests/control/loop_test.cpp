#include "control/loop.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "control/loop_response.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {
namespace {

using std::numbers::pi;

/// A velocity filter of a random order and cut-off.
Filter random_velocity_filter(std::mt19937& rng, double rate) {
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(rng); };
  FilterDesign d{
      1, rate, {{"order", std::floor(uniform(1, 3.999))}, {"cutoff", rate * uniform(0.02, 0.2)}}, {}, {}};
  if (uniform(0, 1) < 0.2) return difference_filter(rate, 1);
  for (const FilterFamily& family : filter_families())
    if (family.name == "butterworth") return family.design(d);
  return {};
}

/// A loop with a bandwidth of some percent of the sample rate; stable mostly.
Control random_control(unsigned seed) {
  std::mt19937 rng(seed);
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(rng); };
  const double rate = std::pow(10, uniform(2, 4.5)), inertia = std::pow(10, uniform(-4, 1)),
               omega = rate * std::pow(10, uniform(-2.5, -0.9));
  Control c;
  c.sample_rate = rate;
  c.delay = (uniform(0, 1) < 0.5 ? std::floor(uniform(0, 2.999)) : uniform(0, 2)) / rate;
  JointController j;
  j.kp = inertia * omega * omega;
  j.kd = 2 * uniform(0.2, 1.2) * inertia * omega;
  j.velocity_filter = random_velocity_filter(rng, rate);
  j.inertia = inertia;
  if (uniform(0, 1) < 0.5) j.damping = inertia * rate * std::pow(10, uniform(-4, 0.5));
  c.joints.push_back(j);
  return c;
}

Loop loop_of(const Control& c) { return loop_of(c, 0, *c.joints[0].inertia); }

LoopResponse response_of_loop(const Control& c) {
  return loop_response(c.joints[0], *c.joints[0].inertia, c.sample_rate, c.samples_of_delay(0));
}

constexpr unsigned random_loops = 24;

TEST(Loop, NormsAreThoseOfTheSimulatedResponse) {
  unsigned stable = 0;
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    const Control c = random_control(seed);
    const auto l = closed(loop_of(c));
    const LoopResponse r = response_of_loop(c);
    ASSERT_EQ(l.has_value(), r.stable) << seed;
    if (!l) continue;
    ++stable;
    const ResponseNorms motion = response_norms(r, &LoopResponse::motion),
                        torque = response_norms(r, &LoopResponse::torque);
    for (const auto& [found, filter] : {std::pair{motion, l->motion}, std::pair{torque, l->torque}}) {
      const Norms n = norms(filter);
      EXPECT_NEAR(found.l1 / n.l1.upper, 1, 1e-8) << seed;
      EXPECT_NEAR(found.h2 / n.h2, 1, 1e-8) << seed;
      EXPECT_LE(n.l1.lower, found.l1 * (1 + 1e-9)) << seed;
    }
    EXPECT_NEAR(motion.dc, -1, 1e-7) << "a constant error is a constant offset " << seed;
  }
  EXPECT_GT(stable, random_loops / 2);
}

/// L at a frequency, from the impulse responses' definition: plant by its difference equation.
std::complex<double> open_loop_at(const Loop& l, double frequency) {
  const std::complex<double> w(0, std::tan(pi * frequency / l.sample_rate));
  const auto value = [&](const PolynomialInW& p) {
    std::complex<double> sum = 0;
    for (std::size_t k = p.size(); k-- > 0;) sum = sum * w + static_cast<double>(p[k]);
    return sum;
  };
  const TransferRatio open = l.open();
  return value(open.b) / value(open.a);
}

TEST(Loop, OfAStatedInertiaHasCertifiedNormsHoweverSlowItIs) {
  Chain chain;
  chain.independent.push_back({.name = "j", .limits = {}});
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(1);
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    const Control c = with_stated_loops(random_control(1000 + seed));
    const std::optional<ClosedLoop> loop = closed(loop_of(c));
    LoopsOfBatch batch(std::make_shared<const Control>(c), chain);
    batch.move_to(q);
    const LoopNorms& known = batch.norms(0, 0);
    EXPECT_EQ(known.stable(), loop.has_value()) << seed;
    if (!loop) continue;
    EXPECT_EQ(known.motion.l1, l1_norm(loop->motion).upper) << seed;
    const LoopResponse& response = batch.response(0, 0);
    if (!response.stable) continue;  // it has not decayed within the samples of the recursion
    EXPECT_NEAR(known.torque.h2, response_norms(response, &LoopResponse::torque).h2, 1e-8 * known.torque.h2)
        << seed;
    EXPECT_NEAR(known.motion.dc, response_norms(response, &LoopResponse::motion).dc, 1e-8) << seed;
  }
  // A stiffness so small that the motion takes hours to decay: stable, with the norms of what it is.
  Control slow = random_control(1);
  slow.joints[0].kp *= 1e-6;
  slow.joints[0].damping = *slow.joints[0].inertia * slow.sample_rate;
  LoopsOfBatch batch(std::make_shared<const Control>(with_stated_loops(slow)), chain);
  batch.move_to(q);
  const LoopNorms& known = batch.norms(0, 0);
  EXPECT_TRUE(known.stable());
  EXPECT_FALSE(batch.response(0, 0).stable);
  EXPECT_NEAR(known.motion.dc, -1, 1e-6);
}

TEST(Loop, RecursionsSideBySideAreThoseOfEachInertia) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const Control c = random_control(2000 + seed);
    const JointController& j = c.joints[0];
    std::vector<double> inertias{0};  // moves at once: no loop
    for (int i = 0; i < 12; ++i) inertias.push_back(*j.inertia * std::pow(1.3, i - 6));
    const std::vector<LoopNorms> found = loop_norms(j, inertias, c.sample_rate, c.samples_of_delay(0));
    ASSERT_EQ(found.size(), inertias.size());
    EXPECT_FALSE(found[0].stable());
    for (std::size_t i = 1; i < inertias.size(); ++i) {
      const LoopResponse r = loop_response(j, inertias[i], c.sample_rate, c.samples_of_delay(0));
      ASSERT_EQ(found[i].stable(), r.stable) << seed << ' ' << i;
      if (!r.stable) continue;
      for (const auto& [norms, of] : {std::pair{found[i].motion, &LoopResponse::motion},
                                      std::pair{found[i].torque, &LoopResponse::torque}}) {
        const ResponseNorms wanted = response_norms(r, of);
        EXPECT_NEAR(norms.l1 / wanted.l1, 1, 1e-10) << seed << ' ' << i;
        EXPECT_NEAR(norms.h2 / wanted.h2, 1, 1e-10) << seed << ' ' << i;
        EXPECT_NEAR(norms.dc, wanted.dc, 1e-9 * wanted.l1) << seed << ' ' << i;
      }
    }
  }
}

TEST(Loop, IsStableBelowItsGainMarginAndUnstableAbove) {
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    const Control c = random_control(seed);
    const LoopMargins m = margins(loop_of(c));
    const auto with_gain = [&](double factor) {
      Control changed = c;
      changed.joints[0].kp *= factor;
      changed.joints[0].kd *= factor;
      return margins(loop_of(changed)).stable;
    };
    if (!m.stable && m.gain == 0) continue;
    if (std::isinf(m.gain)) continue;
    EXPECT_TRUE(with_gain(m.gain * (1 - 1e-6))) << seed;
    EXPECT_FALSE(with_gain(m.gain * (1 + 1e-6))) << seed;
    EXPECT_EQ(m.stable, m.gain > 1) << seed;
  }
}

TEST(Loop, MarginsHoldAtTheirFrequencies) {
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    const Control c = random_control(seed);
    const Loop l = loop_of(c);
    const LoopMargins m = margins(l);
    if (!m.stable) continue;
    ASSERT_TRUE(m.phase && m.bandwidth) << seed;
    const auto at_crossover = open_loop_at(l, *m.crossover);
    EXPECT_NEAR(std::abs(at_crossover), 1, 1e-7) << seed;
    EXPECT_NEAR(std::abs(std::arg(-at_crossover)), *m.phase, 1e-7) << seed;
    if (m.critical_frequency) {
      EXPECT_NEAR(std::abs(open_loop_at(l, *m.critical_frequency) * m.gain + 1.0), 0, 1e-6) << seed;
    }
    const auto at_band = open_loop_at(l, *m.bandwidth);
    EXPECT_NEAR(std::norm(at_band / (1.0 + at_band)), 0.5, 1e-6) << seed;
  }
}

TEST(Loop, ControllerIsOneFilterOfTheSameError) {
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    const Control c = random_control(seed);
    const JointController& j = c.joints[0];
    std::vector<double> h = impulse_response(j.velocity_filter, 400),
                        f = impulse_response(controller_of(j, c.sample_rate), 400);
    for (std::size_t k = 0; k < h.size(); ++k)
      EXPECT_NEAR(f[k], j.kd * h[k] + (k == 0 ? j.kp : 0), 1e-12 * (j.kp + j.kd * std::abs(h[0])))
          << seed << ' ' << k;
  }
}

/// The largest torque and motion in the second half of a run with the quantizer in the loop.
std::pair<double, double> quantized_loop(const Control& c, double count, double offset, double start,
                                         std::size_t samples) {
  const JointController& j = c.joints[0];
  const double rate = c.sample_rate, b = j.damping.value_or(0), m = *j.inertia, delay = c.samples_of_delay(0);
  const auto whole = static_cast<std::size_t>(delay);
  constexpr int fine = 64;  // steps of a sample: the delay is rounded to them
  const auto late = static_cast<std::size_t>(std::round((delay - std::floor(delay)) * fine));
  const double t = 1 / (rate * fine), decay = std::exp(-b * t / m);
  const double v_of_u = b > 0 ? (1 - decay) / b : t / m, q_of_v = b > 0 ? m * (1 - decay) / b : t,
               q_of_u = b * t / m > 1e-3 ? (t - q_of_v) / b : t * t / (2 * m) * (1 - b * t / (3 * m));
  Cascade<double> velocity(j.velocity_filter);
  std::vector<double> past(whole + 2, 0.0);
  double q = start, v = 0, motion = 0, torque = 0;
  std::optional<double> first;
  for (std::size_t k = 0; k < samples; ++k) {
    const double reading = count * std::floor((q - offset) / count + 0.5) + offset;
    if (!first) first = reading;
    past.insert(past.begin(), -j.kp * reading - j.kd * velocity.step(reading - *first));
    past.pop_back();
    if (k > samples / 2) motion = std::max(motion, std::abs(q)), torque = std::max(torque, std::abs(past[0]));
    for (std::size_t i = 0; i < fine; ++i) {
      const double u = i < late ? past[whole + 1] : past[whole];
      q += q_of_v * v + q_of_u * u;
      v = decay * v + v_of_u * u;
    }
  }
  return {motion, torque};
}

TEST(LimitCycle, NoQuantizedLoopExceedsTheBoundsAndSomeComeNear) {
  constexpr double count = 1e-3;
  double nearest = 0;
  for (unsigned seed = 0; seed < random_loops; ++seed) {
    Control c = random_control(seed);
    c.delay = std::round(c.samples_of_delay(0) * 64) / 64 / c.sample_rate;
    const Loop loop = loop_of(c);
    const auto l = closed(loop);
    if (!l) continue;
    const LoopResponse response = response_of_loop(c);
    const std::size_t length = response.motion.size();
    if (length > 20000) continue;
    const LimitCycle bound = limit_cycle(margins(loop), l1_norm(l->motion).upper, l1_norm(l->torque).upper, 1,
                                         {}, count, 0.5 * count);
    for (const double offset : {0.0, 0.5, 0.31, -0.17}) {
      const auto [motion, torque] = quantized_loop(c, count, offset * count, 3 * count, 4 * length);
      EXPECT_LE(motion, bound.bound * (1 + 1e-6)) << seed;
      EXPECT_LE(torque, bound.torque_bound * (1 + 1e-6)) << seed;
      nearest = std::max(nearest, torque / bound.torque_bound);
    }
  }
  EXPECT_GT(nearest, 0.5);
}

TEST(LimitCycle, DescribingFunctionIsTheFirstFourierCoefficientOfRounding) {
  for (const double amplitude : {0.3, 0.55, std::numbers::sqrt2 / 2, 0.9, 1.2, 3.7, 20.0})
    for (const bool on_edge : {false, true}) {
      constexpr int steps = 200'000;
      double sum = 0;
      for (int i = 0; i < steps; ++i) {
        const double phase = 2 * pi * (i + 0.5) / steps, x = amplitude * std::sin(phase);
        sum += std::sin(phase) * (on_edge ? std::floor(x) + 0.5 : std::floor(x + 0.5));
      }
      EXPECT_NEAR(describing_function(amplitude, on_edge), 2 * sum / steps / amplitude, 1e-4)
          << amplitude << on_edge;
    }
  EXPECT_NEAR(describing_function(std::numbers::sqrt2 / 2, false), 4 / pi, 1e-12);
}

TEST(Loop, AnAbsolutelyStableLoopComesToRest) {
  // Strong damping and no integrator beyond one: Re L > -1/2.
  Control c;
  c.sample_rate = 1000;
  JointController j;
  j.kp = 0.4;
  j.inertia = 1e-4;
  j.damping = 1;
  c.joints.push_back(j);
  const Loop l = loop_of(c);
  EXPECT_TRUE(margins(l).absolutely_stable);
  EXPECT_FALSE(margins(loop_of(random_control(1))).absolutely_stable) << "a double integrator never is";
}

}  // namespace
}  // namespace qerr
