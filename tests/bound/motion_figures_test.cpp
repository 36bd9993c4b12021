#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bound/noise_in_motion.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/velocity_estimators.hpp"
#include "support/design_filter.hpp"
#include "support/measured.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;
using testing::Measured;

constexpr long double long_pi = std::numbers::pi_v<long double>;

struct SineMoments {
  long double mean = 0, mean_square = 0;
};

/// E e and E e^2 of a quantized sine, from the arcs between the thresholds it crosses:
/// exact for every amplitude, and with the digits of long double also for the large ones, whose sums cancel.
SineMoments exact_moments(long double offset, long double amplitude) {
  const long double count = std::floor(offset + 0.5L);
  SineMoments m{count - offset, amplitude * amplitude / 2 + (offset - count) * (offset - count)};
  const auto cross = [&](long double t, long double side) {
    const long double arc = std::acos(t / amplitude), root = std::sqrt((amplitude - t) * (amplitude + t));
    m.mean += side * arc / long_pi;
    m.mean_square -= 2 * (root - t * arc) / long_pi;
  };
  for (long double t = count + 0.5L - offset; t < amplitude; ++t) cross(t, 1);
  for (long double t = offset - (count - 0.5L); t < amplitude; ++t) cross(t, -1);
  return m;
}

/// Multiples of 1/64, whose sums have no rounding error: near the sine's peaks the mean is a root of it.
double in_sixty_fourths(double x) { return std::round(64 * x) / 64; }

void expect_exact_moments(double offset, double amplitude) {
  const SineMoments m = exact_moments(offset, amplitude);
  EXPECT_NEAR(quantized_sine_mean(offset, amplitude), static_cast<double>(m.mean), 3e-14)
      << offset << ' ' << amplitude;
  EXPECT_NEAR(quantized_sine_mean_square(offset, amplitude), static_cast<double>(m.mean_square), 3e-14)
      << offset << ' ' << amplitude;
}

TEST(QuantizedSineFigures, AreTheExactIntegralsForSmallAndLargeAmplitudes) {
  Dice dice(61);
  for (int trial = 0; trial < 600; ++trial) {
    const double offset = in_sixty_fourths(dice.between(-3, 3));
    expect_exact_moments(offset, in_sixty_fourths(std::pow(10, dice.between(-1, 2.5))) + 1.0 / 64);
  }
  for (int k = -64; k <= 64; ++k)
    for (const double amplitude : {10.0, 10.5, 11.0, 12.25, 17.484375})
      expect_exact_moments(k / 64.0, amplitude);
}

Autocorrelation autocorrelation_of(const std::vector<double>& h) {
  Autocorrelation a;
  for (std::size_t n = 0; n < h.size(); ++n) {
    a.dc_gain += h[n];
    a.r.push_back(0);
    for (std::size_t k = 0; k + n < h.size(); ++k) a.r.back() += h[k] * h[k + n];
  }
  return a;
}

/// A few random coefficients: of a derivative, whose coefficients sum to 0, or not.
Autocorrelation short_memory(Dice& dice, bool derivative) {
  std::vector<double> h;
  double sum = 0;
  for (std::size_t k = 1 + dice.below(12); k > 0; --k) {
    h.push_back(dice.between(-1, 1));
    sum += h.back();
  }
  h.push_back(derivative ? -sum : dice.between(-1, 1));
  return autocorrelation_of(h);
}

/// sqrt(H(1)^2/12 - sum_n r_n loss(n)).
template <class Loss>
double sigma_by_lags(const Autocorrelation& a, Loss loss) {
  long double sum = static_cast<long double>(a.dc_gain) * a.dc_gain / 12;
  for (std::size_t n = 1; n < a.r.size(); ++n) sum -= a.r[n] * loss(static_cast<long double>(n));
  return static_cast<double>(std::sqrt(std::max(0.0L, sum)));
}

/// E {s}(1 - {s}) of a sine s.
long double loss_of_sine(long double amplitude) {
  return amplitude == 0 ? 0 : 0.25L - exact_moments(0.5L, amplitude).mean_square;
}

TEST(MotionFigures, OfShortFiltersAreTheSumsOverTheirLags) {
  Dice dice(63);
  for (int trial = 0; trial < 120; ++trial) {
    const Autocorrelation a = short_memory(dice, trial % 2 == 0);
    const double ipqn = ipqn_sigma(a);
    EXPECT_NEAR(ipqn * ipqn, a.r[0] / 12, 1e-14 * a.r[0]);
    const double v = std::pow(10, dice.between(-3, 2)) * (dice.chance(0.5) ? -1 : 1);
    const double constant = sigma_by_lags(a, [&](long double n) {
      const long double part = n * v - std::floor(n * v);
      return part * (1 - part);
    });
    EXPECT_NEAR(constant_speed_sigma(a, v), constant, 1e-6 * ipqn);
    const double slow = sigma_by_lags(a, [&](long double n) { return loss_of_sine(n * std::abs(v)); });
    EXPECT_NEAR(slow_sine_sigma(a, v), slow, 1e-7 * ipqn);
    const double cycles = dice.between(0, 1);
    const double sine = sigma_by_lags(a, [&](long double n) {
      return loss_of_sine(2 * std::abs(static_cast<long double>(v) * std::sin(long_pi * n * cycles)));
    });
    EXPECT_NEAR(sine_sigma(a, std::abs(v), cycles), sine, 1e-7 * ipqn);
  }
}

std::string numbered_case(const char* what, int number) { return what + (' ' + std::to_string(number)); }

TEST(MotionFigures, ThresholdsAreAsMeasured) {
  const Measured measured("motion_figures.csv", 1e-8);
  Dice dice(64);
  for (int i = 0; i < 60; ++i) {
    const Autocorrelation a = short_memory(dice, i % 3 > 0);
    const double tolerance = std::pow(10, dice.between(-2, -0.3));
    measured.expect(numbered_case("threshold of random coefficients", i), *ipqn_threshold(a, tolerance));
  }
  int i = 0;
  for (const double tolerance : {0.3, 0.1, 0.03, 0.01}) {
    measured.expect(numbered_case("threshold of one pole", i),
                    *ipqn_threshold(autocorrelation(cascade(1, 1)), tolerance));
    measured.expect(numbered_case("threshold of two poles", i++),
                    *ipqn_threshold(autocorrelation(cascade(2, 2, 120)), tolerance));
  }
  // Far beyond the speed that the search extrapolates from.
  for (const double tolerance : {1e-3, 3e-4})
    measured.expect(numbered_case("threshold of one pole", i++),
                    *ipqn_threshold(autocorrelation(cascade(1, 1, 200)), tolerance));
  // Differences over several samples: the excursions are at fractions of a quantum per sample, too.
  for (std::size_t span = 1; span <= 4; ++span)
    for (const double tolerance : {0.1, 0.02}) {
      std::vector<double> h(2 * span + 1, 0.0);
      h.front() = 1;
      h.back() = span % 2 == 0 ? 1 : -1;
      if (span % 2 == 0) h[span] = -2;
      measured.expect(numbered_case("threshold of a difference", i++),
                      *ipqn_threshold(autocorrelation_of(h), tolerance));
    }
}

TEST(MotionFigures, ThresholdsOfLongMemoriesAreUnknown) {
  Autocorrelation a{std::vector<double>(longest_threshold_search, 0.0), 0, 0};
  a.r[0] = 1;
  a.r[1] = -0.5;
  EXPECT_TRUE(ipqn_threshold(a, 0.1));
  a.r.push_back(0);
  EXPECT_FALSE(ipqn_threshold(a, 0.1));
}

/// Memories too long for an autocorrelation, at fractions with denominators up to the largest one, and
/// beyond.
TEST(MotionFigures, OfSlowFiltersAreAsMeasured) {
  const Measured measured("motion_figures.csv", 1e-8);
  int i = 0;
  for (const int derivative : {0, 1}) {
    const Filter slow = cascade(derivative, 1, 2e-4);
    ASSERT_FALSE(autocorrelation_within(slow));
    for (const double v : {0.0, 0.5, 1.0 / 3, 2.75, -0.2, 7.0 / 1999, 1001.0 / 2000, 1.0 / 2000, 1.0 / 2001,
                           std::numbers::phi})
      measured.expect(numbered_case("slow filter", i++), constant_speed_sigma(slow, v));
  }
}

/// Counts whose product or quotient is rounded are whole nevertheless.
TEST(VelocityEstimatorFigures, HaveNoErrorAtWholeCountsAndTicks) {
  Dice dice(66);
  for (int trial = 0; trial < 500; ++trial) {
    const double resolution = std::pow(10, dice.between(-6, 0)), rate = std::pow(10, dice.between(1, 5));
    const double whole = std::floor(std::pow(10, dice.between(0, 6))), unit = resolution * rate;
    EXPECT_EQ(finite_difference_error(resolution, rate, whole * unit).constant, 0) << whole;
    EXPECT_EQ(inverse_time_error(resolution, rate, unit / whole).constant, 0) << whole;
    const double part = dice.between(1e-3, 0.999);
    EXPECT_NEAR(finite_difference_error(resolution, rate, (whole + part) * unit).constant,
                unit * std::max(part, 1 - part), 1e-9 * whole * unit);
  }
}

TEST(VelocityEstimatorFigures, CrossAtTheLeastNumberOfTicks) {
  Dice dice(67);
  for (int trial = 0; trial < 300; ++trial) {
    const double resolution = std::pow(10, dice.between(-6, 0)), rate = 1000;
    double ratio = std::pow(10, dice.between(-1, 4));
    if (trial % 3 == 0) ratio = static_cast<double>(1 + trial / 3) * (2 + trial / 3);  // m (m + 1) exactly
    if (trial % 3 == 1) ratio = std::pow(static_cast<double>(trial / 3), 2);
    double m = 1;
    while (m * (m + 1) < ratio) ++m;
    EXPECT_DOUBLE_EQ(estimator_crossing(resolution, rate, ratio * rate), resolution * ratio * rate / m);
  }
}

/// By the equations of `operational_error`: from the tip, with the distances R_k of the axes.
TEST(LinearizationRemainderFigures, AreThoseOfTheEquations) {
  Dice dice(65);
  for (int trial = 0; trial < 200; ++trial) {
    const Chain chain = make_chain(testing::random_robot(dice, {1 + dice.below(7)}), "", "");
    const std::size_t joints = chain.joints.size();
    const double size = std::pow(10, dice.between(-5, 0.5));
    const Eigen::VectorXd largest =
        dice.vector(static_cast<Eigen::Index>(chain.independent.size()), 0.1 * size, size);
    const LinearizationRemainder r = linearization_remainder(chain, largest);
    std::vector<double> h, before, distance(joints), levers(joints);
    double sum = 0, axes = 0;
    for (const ChainJoint& joint : chain.joints) {
      h.push_back(std::abs(joint.multiplier) * largest[static_cast<Eigen::Index>(joint.coordinate)]);
      before.push_back(sum);
      if (joint.prismatic) continue;
      axes += 0.5 * h.back() * sum;
      sum += h.back();
    }
    double position = 0, beyond = 0, found = r.position;
    for (std::size_t k = joints; k-- > 0;) {
      distance[k] = dice.between(0, 2);  // of the tip from the axis
      if (chain.joints[k].prismatic) {
        position += before[k] * h[k];
        beyond += h[k];
        EXPECT_EQ(r.per_column[static_cast<Eigen::Index>(k)], 0);
      } else {
        levers[k] = distance[k] + beyond;
        position += 0.5 * levers[k] * h[k] * (2 * before[k] + h[k]);
        beyond += h[k] * levers[k];
        found += r.per_column[static_cast<Eigen::Index>(k)] * distance[k];
      }
    }
    EXPECT_NEAR(found, position, 1e-12 * position);
    EXPECT_NEAR(r.rotation_angle, sum, 1e-14 * sum);
    if (sum <= std::numbers::pi)
      EXPECT_NEAR(r.rotation, axes + sum * sum / 4 + 0.034 * sum * sum * sum, 1e-13 * (axes + sum * sum));
    else
      EXPECT_EQ(r.rotation, INFINITY);
  }
}

}  // namespace
}  // namespace qerr
