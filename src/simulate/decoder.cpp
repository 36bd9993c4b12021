#include "simulate/decoder.hpp"

#include <cmath>
#include <numbers>

namespace qerr {

const std::vector<double>& normal_values() {
  static const std::vector<double> values = [] {
    constexpr int count = 64;
    std::vector<double> v;
    double square = 0;
    for (int i = 0; i < count; ++i) {
      double low = -8, high = 8;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle / std::numbers::sqrt2) < (i + 0.5) / count ? low : high) = middle;
      }
      v.push_back(low);
      square += low * low / count;
    }
    for (double& x : v) x /= std::sqrt(square);
    return v;
  }();
  return values;
}

double Decoder::mean_over_zero(double position, const Moment& m) const {
  const double below = std::floor(position), part = position - below, decoded = (*this)(below, m);
  return part == 0 ? decoded : decoded + part * ((*this)(below + 1, m) - decoded);
}

double Decoder::mean(double position, const Moment& m) const {
  if (noise == 0) return mean_over_zero(position, m);
  double sum = 0;
  for (const double value : normal_values()) sum += mean_over_zero(position + noise * value, m);
  return sum / static_cast<double>(normal_values().size());
}

}  // namespace qerr
