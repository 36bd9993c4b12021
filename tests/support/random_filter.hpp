#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace qerr {

/// Sections (1 + a1 q + a2 q^2 and b) of a hard random filter: poles 1e-9..0.5 from the circle at any angle,
/// also repeated and nearly repeated, zeros anywhere and on the circle, 0-2 differences.
struct RandomFilter {
  using Coefficients = std::array<double, 3>;
  struct Pair {
    Coefficients b, a;
  };
  std::vector<Pair> sections;
  int differences = 0;

  explicit RandomFilter(unsigned seed, std::size_t most_sections = 6, double nearest = 1e-9) : random_(seed) {
    differences = static_cast<int>(3 * uniform());
    const std::size_t count = 1 + static_cast<std::size_t>(static_cast<double>(most_sections) * uniform());
    while (sections.size() < count) {
      const Pair s{zeros(), poles(nearest)};
      // Rounding the coefficients can move a pole near the unit circle onto it.
      if (s.a[2] < 1 && std::abs(s.a[1]) < 1 + s.a[2]) sections.push_back(s);
    }
  }

 private:
  double uniform(double from = 0, double to = 1) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }
  double log_uniform(double from, double to) { return std::exp(uniform(std::log(from), std::log(to))); }

  double angle() {
    const double kind = uniform();
    if (kind < 0.25) return log_uniform(1e-8, 1);
    if (kind < 0.35) return std::numbers::pi - log_uniform(1e-8, 1);
    return uniform(0, std::numbers::pi);
  }

  Coefficients poles(double nearest) {
    const double kind = uniform();
    if (kind < 0.2) return {1, -(2 - log_uniform(nearest, 0.5)), 1 - log_uniform(nearest, 0.5)};
    if (kind < 0.4) {  // two real ones
      const double sign = uniform() < 0.7 ? 1 : -1;
      const double x = sign * (1 - log_uniform(nearest, 0.5)), y = sign * (1 - log_uniform(nearest, 0.5));
      return {1, -(x + y), x * y};
    }
    const double again = uniform();
    if (again < 0.2 && modulus_ > 0) return around(modulus_, angle_);  // repeated
    if (again < 0.4 && modulus_ > 0) {                                 // nearly so
      const double gap = (1 - modulus_) * log_uniform(1e-9, 0.5);
      return around(modulus_ - gap, angle_ + gap * uniform(-1, 1));
    }
    modulus_ = 1 - log_uniform(nearest, 0.5);
    angle_ = angle();
    return around(modulus_, angle_);
  }

  Coefficients zeros() {
    const double kind = uniform();
    if (kind < 0.2) return {1, 0, 0};
    if (kind < 0.4) return {1, -2 * std::cos(angle()), 1};  // on the circle
    const double at = angle();  // before the modulus: the order of arguments is the compiler's
    return kind < 0.6 ? around(1 - log_uniform(1e-9, 0.5), at) : around(uniform(0, 2), at);
  }

  static Coefficients around(double modulus, double angle) {
    return {1, -2 * modulus * std::cos(angle), modulus * modulus};
  }

  std::mt19937 random_;
  double modulus_ = 0, angle_ = 0;
};

}  // namespace qerr
