
#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// H = alpha/(1 - (1 - alpha) z^-1) = (1 + w)/(1 + w (2 - alpha)/alpha); the slope (2 - alpha)/alpha is
/// coth(T/(2 tau)) for a time constant tau, alpha = 1 - exp(-T/tau), and the span itself for alpha = 2/(span
/// + 1).
DoubleDouble slope_of(const FilterDesign& wanted) {
  switch (parameter_group(wanted, {{"alpha"}, {"time_constant"}, {"span"}})) {
    case 0: {
      const DoubleDouble alpha = checked_number(wanted, "alpha", 0, 1);
      return (DoubleDouble(2) - alpha) / alpha;
    }
    case 1: {
      const double tau = checked_number(wanted, "time_constant", 0, INFINITY);
      const Real x = expm1(-1 / (Real(wanted.sample_rate) * tau));
      return to_double_double(-(2 + x) / x);  // coth(T/(2 tau))
    }
    default: {
      const double span = wanted.numbers.at("span");
      if (!(span >= 1)) throw Error("span", "is out of range", figure(span), "at least 1");
      return span;
    }
  }
}

Filter design(const FilterDesign& wanted) {
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = true;
  const DoubleDouble slope = slope_of(wanted);
  // The zero at z = 0, w = -1, cancels the pole of a difference.
  if (filter.sections.empty()) filter.sections.push_back({{1, 1, 0}, {}});
  filter.sections[0].a = {1, slope, 0};
  return filter;
}

}  // namespace

FilterFamily exponential_moving_average_family() {
  return {
      "exponential_moving_average",
      "back differences, then y_k = alpha x_k + (1 - alpha) y_(k-1), given by one of alpha, time_constant, "
      "span (as in pandas)",
      {key::number("alpha", "weight of the newest sample").above(0).up_to(1),
       key::number("time_constant", "alpha = 1 - exp(-T/time_constant)", dimension::time).above(0),
       key::number("span", "alpha = 2/(span + 1)").from(1)},
      design};
}

}  // namespace qerr
