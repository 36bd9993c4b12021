#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// prod 1/(1 + 2 sin(theta_i) (w/rho) + (w/rho)^2), theta_i = pi (2i + 1)/(2n), rho = tan(pi f0 T): -3 dB
/// exactly at f0.
Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 2, 1, max_order);
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = true;
  const DoubleDouble slope = prewarped_slope(checked_cutoff(wanted), wanted.sample_rate);
  if (order % 2 == 1) filter.sections.push_back({{1, 0, 0}, {1, slope, 0}});
  for (int i = 0; i < order / 2; ++i) {
    const DoubleDouble damping = to_double_double(2 * sin(pi256() * (2 * i + 1) / (2 * order)));
    filter.sections.push_back({{1, 0, 0}, {1, damping * slope, slope * slope}});
  }
  return filter;
}

}  // namespace

FilterFamily butterworth_family() {
  return {"butterworth",
          "back differences, then a Butterworth low-pass (bilinear, pre-warped)",
          {order_row(2), cutoff_row("-3 dB frequency of the low-pass, below half the sample rate")},
          design,
          {2, 3, 4}};  // of order 1 it is a first-order low-pass
}

}  // namespace qerr
