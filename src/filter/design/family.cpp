#include "qerr/filter/family.hpp"

#include <cmath>

#include "filter/design/families/families.hpp"
#include "filter/design/representations/representations.hpp"

namespace qerr {

const std::vector<FilterFamily>& filter_families() {
  static const std::vector<FilterFamily> list{
      first_order_family(),
      butterworth_family(),
      bessel_family(),
      chebyshev1_family(),
      chebyshev2_family(),
      elliptic_family(),
      exponential_moving_average_family(),
      finite_difference_family(),
      savitzky_golay_family(),
      least_squares_family(),
      kalman_family(),
      alpha_beta_family(),
      alpha_beta_gamma_family(),
      tracking_loop_family(),
  };
  return list;
}

Filter difference_filter(double sample_rate, int derivative) {
  check_sample_rate(sample_rate);
  check_derivative(derivative);
  Filter filter{{}, 1, sample_rate, derivative};
  for (int i = 0; i < derivative; ++i) {
    filter.sections.push_back({{0, 1, 0}, {1, 1, 0}});  // 1 - z^-1 = 2w/(1 + w)
    filter.gain *= 2 * sample_rate;
  }
  return filter;
}

const std::vector<FilterRepresentation>& filter_representations() {
  static const std::vector<FilterRepresentation> list{
      coefficients_representation(),          sections_representation(),
      zero_pole_gain_representation(),        state_space_representation(),
      ros_transfer_function_representation(),
  };
  return list;
}

std::vector<double> flat(const Rows& rows, const std::string& key) {
  std::vector<double> list;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() != 1) {
      throw Error(key + '[' + std::to_string(i) + ']', "must be one number",
                  "a list of " + std::to_string(rows[i].size()), "write [c0, c1, ...]");
    }
    list.push_back(rows[i][0]);
  }
  return list;
}

void check_finite(const Rows& rows, const std::string& key) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const double x : rows[i]) {
      if (!std::isfinite(x))
        throw Error(key + '[' + std::to_string(i) + ']', "the numbers must be finite", figure(x), "");
    }
  }
}

Error unstable(const std::string& key, double largest_modulus) {
  return Error(key,
               "the filter is not stable: a pole lies on or outside the unit circle, or within the rounding "
               "of its numbers of it",
               "largest pole modulus " + figure(largest_modulus), "all poles must lie inside");
}

}  // namespace qerr
