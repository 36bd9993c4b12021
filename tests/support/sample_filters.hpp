#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "qerr/filter/family.hpp"

namespace qerr {

/// A design of a family for the tests that run every member: for derivative 0 .. most_derivative.
struct SampleFilter {
  std::string family;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;
  int most_derivative = max_derivative;
  double low_frequency_gain = 1;  ///< of H/(j 2 pi f)^d at 0 Hz; below 1 where ripple starts lower
};

/// At least one of every family; a family without one fails the contract test.
inline std::vector<SampleFilter> sample_filters() {
  const double ripple = 0.89125093813374556;  // -1 dB
  return {{"first_order", {{"order", 3}, {"cutoff", 50}}, {}},
          {"butterworth", {{"order", 3}, {"cutoff", 50}}, {}},
          {"bessel", {{"order", 4}, {"cutoff", 50}}, {{"normalization", "delay"}}},
          {"chebyshev1", {{"order", 3}, {"cutoff", 50}, {"ripple", 1}}, {}},
          {"chebyshev1", {{"order", 4}, {"cutoff", 50}, {"ripple", 1}}, {}, max_derivative, ripple},
          {"chebyshev2", {{"order", 4}, {"cutoff", 50}, {"attenuation", 40}}, {}},
          {"elliptic", {{"order", 3}, {"cutoff", 50}, {"ripple", 1}, {"attenuation", 40}}, {}},
          {"elliptic",
           {{"order", 4}, {"cutoff", 50}, {"ripple", 1}, {"attenuation", 40}},
           {},
           max_derivative,
           ripple},
          {"exponential_moving_average", {{"alpha", 0.2}}, {}},
          {"exponential_moving_average", {{"time_constant", 0.01}}, {}},
          {"finite_difference", {{"span", 5}}, {}},
          {"finite_difference", {{"span", 1}, {"accuracy", 3}}, {}},
          {"savitzky_golay", {{"window", 21}, {"polynomial_order", 5}}, {{"position", "end"}}, 5},
          {"savitzky_golay", {{"window", 20}, {"polynomial_order", 4}}, {{"position", "center"}}, 4},
          {"least_squares", {{"window", 25}}, {}},
          {"kalman", {{"tracking_index", 0.05}}, {{"model", "constant_velocity"}}, 1},
          {"kalman",
           {{"process_noise", 1e3}, {"measurement_noise", 1e-5}},
           {{"model", "constant_acceleration"}},
           2},
          {"alpha_beta", {{"alpha", 0.4}, {"damping", 1}}, {}, 1},
          {"alpha_beta_gamma", {{"alpha", 0.5}, {"beta", 0.2}, {"gamma", 0.05}}, {}, 2},
          {"tracking_loop", {{"bandwidth", 200}}, {}, 1}};
}

inline Filter designed(const SampleFilter& sample, int derivative, double sample_rate = 1000) {
  for (const FilterFamily& family : filter_families()) {
    if (family.name == sample.family)
      return family.design({derivative, sample_rate, sample.numbers, sample.choices, {}});
  }
  throw std::runtime_error("no family " + sample.family);
}

}  // namespace qerr
