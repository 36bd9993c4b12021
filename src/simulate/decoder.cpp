#include "simulate/decoder.hpp"

#include <cmath>
#include <numbers>

#include "core/search.hpp"

namespace qerr {

const std::vector<double>& normal_values() {
  static const std::vector<double> values = [] {
    constexpr int count = 64;
    std::vector<double> v;
    double square = 0;
    for (int i = 0; i < count; ++i) {
      const auto below = [&](double x) {
        return 0.5 * std::erfc(-x / std::numbers::sqrt2) < (i + 0.5) / count;
      };
      v.push_back(bisect({-8, 8}, 60, below).holds);
      square += v.back() * v.back() / count;
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
