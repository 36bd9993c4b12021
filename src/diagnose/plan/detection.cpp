#include "diagnose/plan/detection.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

constexpr double reach = 8;  ///< of the Gaussian [sigma]

double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

/// Phi(b) - Phi(a), by the tail on the side where both lie.
double between(double a, double b) {
  const double sign = a + b < 0 ? -1 : 1;
  return 0.5 *
         std::abs(std::erfc(sign * a / std::numbers::sqrt2) - std::erfc(sign * b / std::numbers::sqrt2));
}

}  // namespace

ReadingInformation reading_information(double noise) {
  // The middle rule over one count, fine enough for the width of an edge.
  const int points = static_cast<int>(std::clamp(40 / noise, 200.0, 40000.0));
  const double most = std::ceil(reach * noise);
  ReadingInformation sum;
  for (int i = 0; i < points; ++i) {
    const double x = (i + 0.5) / points;
    for (double k = -most; k <= most; ++k) {
      const double a = (k - x) / noise, b = (k + 1 - x) / noise, p = between(a, b);
      if (p < 1e-14) continue;
      const double position = density(a) - density(b), scatter = a * density(a) - b * density(b);
      sum.position += position * position / p;
      sum.scatter += scatter * scatter / p;
    }
  }
  return {sum.position / (points * noise * noise), sum.scatter / points};
}

double needed_noncentrality(double threshold, double freedom, double power) {
  return boost::math::non_central_chi_squared::find_non_centrality(freedom, threshold, 1 - power);
}

double chi_squared_beyond(double freedom, double p) {
  return boost::math::quantile(complement(boost::math::chi_squared(freedom), p));
}

}  // namespace qerr
