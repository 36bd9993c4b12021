#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

/// 1/rho of the low-pass pole w = -rho, x = 2 pi f0 T.
///
/// matched a = exp(-x): rho = tanh(x/2); Tustin rho = x/2, pre-warped tan(x/2); backward Euler a = 1/(1 + x).
Real inverse_pole(const std::string& discretization, const Real& x) {
  if (discretization == "matched") return -(2 + expm1(-x)) / expm1(-x);  // 1/tanh(x/2)
  if (discretization == "tustin") return 2 / x;
  if (discretization == "prewarped") return cos(x / 2) / sin(x / 2);
  if (discretization == "backward_euler") return 1 + 2 / x;
  throw Error("discretization", "unknown discretization", "'" + escaped(discretization) + "'",
              "use matched, tustin, prewarped or backward_euler");
}

Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 1, 0, max_order);
  const auto choice = wanted.choices.find("discretization");
  const std::string discretization = choice == wanted.choices.end() ? "matched" : choice->second;
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = order > 0;
  const Real x = 2 * pi256() * checked_cutoff(wanted) / wanted.sample_rate;
  const DoubleDouble slope = to_double_double(inverse_pole(discretization, x));
  const bool bilinear = discretization == "tustin" || discretization == "prewarped";
  for (int i = 0; i < order; ++i) {
    // Bilinear low-passes have a zero at w = infinity (Nyquist), the others at z = 0 (w = -1), which cancels
    // the pole of a difference.
    if (!bilinear && i < wanted.derivative) {
      filter.sections[i].a = {1, slope, 0};
    } else {
      filter.sections.push_back({{1, bilinear ? 0.0 : 1.0, 0}, {1, slope, 0}});
    }
  }
  return filter;
}

}  // namespace

FilterFamily first_order_family() {
  return {"first_order",
          "back differences, then one-pole low-passes (1 - a)/(1 - a z^-1), a = exp(-2 pi f0 T)",
          {key::integer("order", "number of low-pass sections; 0: differences only")
               .otherwise(1)
               .within(0, max_order),
           cutoff_row("cut-off f0 of each section, below half the sample rate"),
           key::choice("discretization", "matched|tustin|prewarped|backward_euler", "of the pole 2 pi f0")},
          design,
          {1, 2, 3, 4}};
}

}  // namespace qerr
