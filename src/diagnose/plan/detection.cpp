#include "diagnose/plan/detection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/probability.hpp"

namespace qerr {

namespace {

constexpr double reach = 8;  ///< of the Gaussian [sigma]

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

}  // namespace

ReadingInformation reading_information(double noise) {
  // The middle rule over one count, fine enough for the width of an edge.
  const int points = static_cast<int>(std::clamp(40 / noise, 200.0, 40000.0));
  const double most = std::ceil(reach * noise);
  ReadingInformation sum;
  for (int i = 0; i < points; ++i) {
    const double x = (i + 0.5) / points;
    for (double k = -most; k <= most; ++k) {
      const double a = (k - x) / noise, b = (k + 1 - x) / noise, p = normal_probability(a, b);
      if (p < 1e-14) continue;
      const double position = density(a) - density(b), scatter = a * density(a) - b * density(b);
      sum.position += position * position / p;
      sum.scatter += scatter * scatter / p;
    }
  }
  return {sum.position / (points * noise * noise), sum.scatter / points};
}

}  // namespace qerr
