#include <algorithm>
#include <cmath>

#include "filter/design/families/prototype.hpp"
#include "filter/design/roots.hpp"

namespace qerr {
namespace {

/// sum_k (2n - k)!/(2^(n-k) k! (n-k)!) s^k, descending; exact in double-double up to order 25.
std::vector<Wide> reverse_bessel_polynomial(int n) {
  std::vector<Wide> descending{1};
  for (int k = n; k > 0; --k) {  // c_(k-1) = c_k (2n - k + 1) k / (2 (n - k + 1))
    descending.push_back(descending.back() * Wide((2 * n - k + 1) * k) / Wide(2 * (n - k + 1)));
  }
  return descending;
}

/// The frequency [rad/s] at which prod 1/|1 - jx/p|^2 is one half.
Wide half_power_frequency(const std::vector<WideComplex>& poles) {
  Wide low = 0, high = 100;
  for (int i = 0; i < 120; ++i) {
    const Wide x = (low + high) * Wide(0.5);
    Wide power = 1;
    for (const WideComplex& p : poles) power *= norm(WideComplex(1.0) - WideComplex(0.0, x) / p);
    (power < Wide(2) ? low : high) = x;
  }
  return low;
}

Filter design(const FilterDesign& wanted) {
  const int order = whole_number(wanted, "order", 2, 1, max_order);
  const std::string normalization = checked_choice(wanted, "normalization", {"phase", "delay", "magnitude"});
  const std::vector<Wide> polynomial = reverse_bessel_polynomial(order);
  std::vector<Long> descending;
  for (const Wide& c : polynomial) descending.push_back(to_long(c));
  std::vector<WideComplex> all;
  for (const LongComplex& p : roots(descending)) all.push_back({to_wide(p.re), to_wide(p.im)});
  Wide scale = 1;
  if (normalization == "phase") scale = std::pow(static_cast<double>(polynomial.back()), -1.0 / order);
  if (normalization == "magnitude") scale = Wide(1) / half_power_frequency(all);
  Prototype prototype;
  for (const WideComplex& p : all) {
    if (!(p.im < Wide(0))) prototype.poles.push_back({p.re * scale, p.im * scale});
  }
  return bilinear_lowpass(wanted, prototype);
}

}  // namespace

FilterFamily bessel_family() {
  return {"bessel",
          "back differences, then a Bessel low-pass (bilinear, pre-warped): flattest delay of its order",
          {order_row(2),
           cutoff_row("where the analog prototype's 1 rad/s lies, below half the sample rate"),
           {.name = "normalization",
            .kind = Kind::choice,
            .meaning = "what the cut-off is: midpoint of the phase, 1/(2 pi delay), or -3 dB",
            .choices = "phase|delay|magnitude"}},
          design};
}

}  // namespace qerr
