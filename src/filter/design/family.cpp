#include "qerr/filter/family.hpp"

#include "filter/design/families/families.hpp"

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

}  // namespace qerr
