#include "diagnose/plan/reading_information.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/probability.hpp"

namespace qerr {

namespace {

constexpr double tails = 8;  ///< of the normal density that are integrated [sigma]

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

}  // namespace

ReadingInformation reading_information(double noise) {
  // Midpoint rule over one count, with 40 points per standard deviation of the noise.
  const int points = static_cast<int>(std::clamp(40 / noise, 200.0, 40000.0));
  const double most = std::ceil(tails * noise);
  ReadingInformation sum;
  for (int i = 0; i < points; ++i) {
    const double x = (i + 0.5) / points;
    for (double k = -most; k <= most; ++k) {
      const double a = (k - x) / noise, b = (k + 1 - x) / noise, p = normal_probability(a, b);
      if (p < 1e-14) continue;
      const double by_position = density(a) - density(b), by_sigma = a * density(a) - b * density(b);
      sum.position += by_position * by_position / p;
      sum.log_sigma += by_sigma * by_sigma / p;
    }
  }
  return {sum.position / (points * noise * noise), sum.log_sigma / points};
}

}  // namespace qerr
