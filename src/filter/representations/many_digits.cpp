#include "many_digits.hpp"

#include <algorithm>
#include <cmath>

namespace qerr::many_digits {

Wide to_wide(const Real& x) {
  const double high = static_cast<double>(x);
  return {high, static_cast<double>(Real(x - high))};
}

std::vector<Complex> roots(const Vector& ascending) {
  const std::size_t n = ascending.size() - 1;
  if (n == 0) return {};
  const Real radius = pow(Real(abs(ascending[0] / ascending[n])), Real(1) / static_cast<double>(n));
  std::vector<Complex> z(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = 6.283185307179586 * static_cast<double>(k) / static_cast<double>(n) + 0.4;
    z[k] = {radius * std::cos(angle), radius * std::sin(angle)};
  }
  const Real enough("1e-80");  // its square: 40 digits
  for (int sweep = 0; sweep < 600; ++sweep) {
    Real largest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Complex value{0, 0}, slope{0, 0};
      for (std::size_t k = n + 1; k-- > 0;) {
        slope = slope * z[i] + value;
        value = value * z[i] + Complex{ascending[k], 0};
      }
      if (value.square() == 0 || slope.square() == 0) continue;
      Complex others{0, 0};
      for (std::size_t j = 0; j < n; ++j) {
        const Complex gap = z[i] - z[j];
        if (j != i && gap.square() != 0) others = others + Complex{1, 0} / gap;
      }
      const Complex newton = value / slope, brake = Complex{1, 0} - newton * others;
      const Complex step = brake.square() != 0 ? newton / brake : newton;
      z[i] = z[i] - step;
      largest = std::max(largest, Real(step.square() / z[i].square()));
    }
    if (largest < enough) break;
  }
  return z;
}

}  // namespace qerr::many_digits
