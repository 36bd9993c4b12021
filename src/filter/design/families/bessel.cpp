
#include "filter/design/families/families.hpp"
#include "filter/design/polynomial.hpp"

namespace qerr {
namespace {

/// sum_k (2n - k)!/(2^(n-k) k! (n-k)!) s^k, descending; exact in double-double up to order 25.
std::vector<DoubleDouble> reverse_bessel_polynomial(int n) {
  std::vector<DoubleDouble> descending{1};
  for (int k = n; k > 0; --k) {  // c_(k-1) = c_k (2n - k + 1) k / (2 (n - k + 1))
    descending.push_back(descending.back() * DoubleDouble((2 * n - k + 1) * k) /
                         DoubleDouble(2 * (n - k + 1)));
  }
  return descending;
}

/// The frequency [rad/s] at which prod 1/|1 - jx/p|^2 is one half.
DoubleDouble half_power_frequency(const std::vector<ComplexDoubleDouble>& poles) {
  DoubleDouble low = 0, high = 100;
  for (int i = 0; i < 120; ++i) {
    const DoubleDouble x = (low + high) * DoubleDouble(0.5);
    DoubleDouble power = 1;
    for (const ComplexDoubleDouble& p : poles)
      power *= norm(ComplexDoubleDouble(1.0) - ComplexDoubleDouble(0.0, x) / p);
    (power < DoubleDouble(2) ? low : high) = x;
  }
  return low;
}

Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 2, 1, max_order);
  const std::string normalization = checked_choice(wanted, "normalization", {"phase", "delay", "magnitude"});
  const std::vector<DoubleDouble> polynomial = reverse_bessel_polynomial(order);
  std::vector<Binary1024> descending;
  for (const DoubleDouble& c : polynomial) descending.push_back(to_binary1024(c));
  std::vector<ComplexDoubleDouble> all;
  for (const Complex1024& p : roots(descending))
    all.push_back({to_double_double(p.re), to_double_double(p.im)});
  DoubleDouble scale = 1;
  if (normalization == "phase") {
    const Real last = Real(polynomial.back().hi) + Real(polynomial.back().lo);
    scale = to_double_double(exp(-log(last) / order));
  }
  if (normalization == "magnitude") scale = DoubleDouble(1) / half_power_frequency(all);
  Prototype prototype;
  for (const ComplexDoubleDouble& p : all) {
    if (!(p.im < DoubleDouble(0))) prototype.poles.push_back({p.re * scale, p.im * scale});
  }
  return bilinear_lowpass(wanted, prototype);
}

}  // namespace

FilterFamily bessel_family() {
  return {
      "bessel",
      "back differences, then a Bessel low-pass (bilinear, pre-warped): maximally flat group delay",
      {order_row(2), cutoff_row("frequency of the analog prototype's 1 rad/s, below half the sample rate"),
       key::choice("normalization", "phase|delay|magnitude",
                   "meaning of the cut-off: midpoint of the phase, 1/(2 pi delay), or -3 dB")},
      design};
}

}  // namespace qerr
