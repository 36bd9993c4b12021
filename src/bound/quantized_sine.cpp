#include <algorithm>
#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/special_functions/zeta.hpp>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "qerr/bound/velocity_estimators.hpp"

namespace qerr {

namespace {

using std::numbers::pi;
constexpr double large = 10;  // [quanta]: above, (2 pi A)^-9 is below 1e-15

/// Calls visit(t, side) for the quantizer's thresholds at distances t < amplitude above (side +1) and below
/// (-1) the offset.
template <class Visit>
void each_threshold(double offset, double amplitude, Visit visit) {
  const double within = offset - std::floor(offset + 0.5);
  for (double t = 0.5 - within; t < amplitude; t += 1) visit(t, +1.0);
  for (double t = 0.5 + within; t < amplitude; t += 1) visit(t, -1.0);
}

double root(double amplitude, double t) { return std::sqrt((amplitude - t) * (amplitude + t)); }

/// sum_m a_m (2 pi A)^-m Re[e^{i phase} i^m F(x, s + m)], F(x, s) = sum_k e^{2 pi i k x} k^-s.
///
/// a_m: Hankel's coefficients of J_0 (DLMF 10.17.1). F near x = 0 (DLMF 25.12.12): Gamma(1 - s)(-2 pi i x)^(s
/// - 1) + sum_k zeta(s - k)(2 pi i x)^k/k!. For the phases used here the first term is real for x > 0 and
/// vanishes for x < 0: the singularity where a peak of the sine crosses a threshold.
class HankelSum {
 public:
  HankelSum(double s, double phase) : lowest_power_(s - 1) {
    for (std::size_t m = 0; m < orders; ++m) {
      const double order = s + static_cast<double>(m);
      turning_[m] = -boost::math::tgamma(1 - order) * std::pow(2 * pi, order - 1);
      double factor = 1;
      for (std::size_t k = 0; k < terms; ++k) {
        const double degree = static_cast<double>(k);
        smooth_[m][k] = std::cos(phase + 0.5 * pi * static_cast<double>(m + k)) *
                        boost::math::zeta(order - degree) * factor;
        factor *= 2 * pi / (degree + 1);
      }
    }
  }

  /// @param bits  of the sum that are wanted
  double operator()(double x, double amplitude, int bits = full_bits) const {
    x -= std::floor(x + 0.5);
    // Successive terms shrink by |x| <= 1/2.
    const double bits_per_term = -std::log2(std::abs(x));
    const double negligible = std::ldexp(18, -bits);
    double sum = 0, weight = 1, power = x > 0 ? std::sqrt(x) * (lowest_power_ > 1 ? x : 1) : 0;
    for (std::size_t m = 0; m < orders && std::abs(weight) > negligible; ++m) {
      // Smaller weights need fewer digits.
      const int needed = static_cast<int>((bits + std::ilogb(weight)) / bits_per_term);
      // Separate recursions for even and odd terms run in parallel.
      double even = 0, odd_terms = 0;
      for (std::size_t k = std::min(terms, static_cast<std::size_t>(needed / 2 * 2 + 2)); k > 0; k -= 2) {
        odd_terms = odd_terms * x * x + smooth_[m][k - 1];
        even = even * x * x + smooth_[m][k - 2];
      }
      sum += weight * (even + x * odd_terms + turning_[m] * power);
      power *= x;
      const double odd = 2 * static_cast<double>(m) + 1;
      weight *= -odd * odd / (8 * (static_cast<double>(m) + 1) * 2 * pi * amplitude);
    }
    return sum;
  }

 private:
  static constexpr std::size_t orders = 9, terms = 52;
  double lowest_power_;  // 1/2 or 3/2
  std::array<double, orders> turning_{};
  std::array<std::array<double, terms>, orders> smooth_{};
};

const HankelSum& first_power() {
  static const HankelSum sum(1.5, -0.75 * pi);
  return sum;
}

const HankelSum& second_power() {
  static const HankelSum sum(2.5, -0.25 * pi);
  return sum;
}

}  // namespace

double quantized_sine_mean(double offset, double amplitude) {
  if (amplitude < large) {
    double sum = std::floor(offset + 0.5) - offset;
    each_threshold(offset, amplitude,
                   [&](double t, double side) { sum += side * std::acos(t / amplitude) / pi; });
    return sum;
  }
  const double v = offset + 0.5;
  const HankelSum& sum = first_power();
  return (sum(amplitude + v, amplitude) - sum(amplitude - v, amplitude)) /
         (2 * pi * pi * std::sqrt(amplitude));
}

double quantized_sine_mean_square(double offset, double amplitude, int bits) {
  if (amplitude < large) {
    // e^2 = (x - n)^2 - 2 sum (|x - n| - t where beyond a threshold t), n the count nearest to the offset.
    const double within = offset - std::floor(offset + 0.5);
    double sum = 0.5 * amplitude * amplitude + within * within;
    each_threshold(offset, amplitude, [&](double t, double) {
      sum -= 2 * (root(amplitude, t) - t * std::acos(t / amplitude)) / pi;
    });
    return sum;
  }
  const double v = offset + 0.5;
  const HankelSum& sum = second_power();
  const double above = sum(amplitude + v, amplitude, bits);
  // Equal at offset 1/2, the argument of autocorrelations (noise_in_motion.cpp).
  const double below = v == 1 ? above : sum(amplitude - v, amplitude, bits);
  return 1.0 / 12 + (above + below) / (2 * pi * pi * pi * std::sqrt(amplitude));
}

SineEnvelope quantized_sine_envelope(double amplitude) {
  const double root_of_amplitude = std::sqrt(amplitude);
  return {0.135 / root_of_amplitude, -0.029 / root_of_amplitude, 0.038 / root_of_amplitude};
}

}  // namespace qerr
