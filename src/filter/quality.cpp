#include "qerr/filter/quality.hpp"

#include <cmath>
#include <numbers>

#include "filter/corners.hpp"
#include "filter/tracking_error.hpp"

namespace qerr {

double low_frequency_gain(const Filter& filter) { return limit_at_dc(filter); }

bool estimates_its_derivative(const Filter& filter) {
  const double gain = low_frequency_gain(filter);
  return gain > 0.5 && gain < 2;
}

bool passes_slow_motion(const Filter& filter) {
  constexpr double most = 0.01;  // gains of lower ripple change noise by less than other choices do
  return std::abs(low_frequency_gain(filter) - 1) <= most;
}

Fidelity fidelity(const Filter& filter, double f) { return TrackingError(filter).fidelity(f); }

double noise_bandwidth(const Filter& filter, double h2) {
  const int d = filter.derivative;
  const double density = (2 * d + 1) * 0.5 * filter.sample_rate / std::pow(2 * std::numbers::pi, 2 * d);
  return std::pow(density, 1.0 / (2 * d + 1)) * std::pow(h2, 2.0 / (2 * d + 1));
}

std::vector<std::array<double, 6>> second_order_sections(const Filter& filter) {
  std::vector<std::array<double, 6>> sections;
  for (const Section& s : filter.sections) {
    // w = (1 - q)/(1 + q), numerator and denominator times (1 + q) to the section's order.
    const bool second = s.a[2] != 0 || s.b[2] != 0;
    const auto in_z = [&](const std::array<DoubleDouble, 3>& c) {
      return second ? std::array<DoubleDouble, 3>{c[0] + c[1] + c[2], DoubleDouble(2) * (c[0] - c[2]),
                                                  c[0] - c[1] + c[2]}
                    : std::array<DoubleDouble, 3>{c[0] + c[1], c[0] - c[1], 0};
    };
    const auto b = in_z(s.b), a = in_z(s.a);
    const auto over = [&](DoubleDouble c) { return static_cast<double>(c / a[0]); };
    sections.push_back({over(b[0]), over(b[1]), over(b[2]), 1, over(a[1]), over(a[2])});
  }
  if (sections.empty()) sections.push_back({1, 0, 0, 1, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) sections.front()[i] *= static_cast<double>(filter.gain);
  return sections;
}

}  // namespace qerr
