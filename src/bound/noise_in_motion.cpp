#include "qerr/bound/noise_in_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "qerr/bound/quantized_sine.hpp"

namespace qerr {

namespace {

constexpr double pi = std::numbers::pi;

/// {s}(1 - {s}), for |s| < 2^51. The addition rounds to the nearest integer and, unlike floor, in a vector.
double loss(double s) {
  constexpr double magic = 0x1.8p52;
  const double part = std::abs(s - ((s + magic) - magic));
  return part * (1 - part);
}

/// E {s}(1 - {s}) of a sine of this amplitude: 1/4 - E e^2 of s + 1/2.
double sine_loss(double amplitude) { return 0.25 - quantized_sine_mean_square(0.5, amplitude); }

/// sqrt(H(1)^2/12 - sum r_n loss_of(n)), summed from the small end.
template <class Loss>
double sigma_of(const Autocorrelation& a, Loss loss_of) {
  double sum = 0;
  for (std::size_t n = a.r.size(); n-- > 1;) sum += a.r[n] * loss_of(n);
  return std::sqrt(std::max(0.0, a.dc_gain * a.dc_gain / 12 - sum));
}

}  // namespace

double constant_speed_sigma(const Autocorrelation& a, double v) {
  const double speed = std::abs(std::remainder(v, 1.0));
  return sigma_of(a, [&](std::size_t n) { return loss(static_cast<double>(n) * speed); });
}

double constant_speed_sigma(const Filter& filter, double v) {
  return constant_speed_sigma(autocorrelation(filter), v);
}

double sine_sigma(const Autocorrelation& a, double amplitude, double cycles) {
  return sigma_of(a, [&](std::size_t n) {
    return sine_loss(2 * amplitude *
                     std::abs(std::sin(pi * std::remainder(static_cast<double>(n) * cycles, 1.0))));
  });
}

double slow_sine_sigma(const Autocorrelation& a, double peak) {
  return sigma_of(a, [&](std::size_t n) { return sine_loss(static_cast<double>(n) * std::abs(peak)); });
}

double path_sigma(const Autocorrelation& a, std::span<const double> x) {
  constexpr double most_pairs = 2e8;
  const std::size_t lags = std::min(a.r.size(), x.size() / 2 + 1);
  const double pairs = static_cast<double>(lags) * static_cast<double>(x.size());
  const auto step = static_cast<std::size_t>(1 + pairs / most_pairs);
  return sigma_of(a, [&](std::size_t n) {
    if (n >= lags) return 1.0 / 6;
    double sum = 0;
    for (std::size_t k = 0; k + n < x.size(); k += step) sum += loss(x[k + n] - x[k]);
    return sum / static_cast<double>((x.size() - n + step - 1) / step);
  });
}

double speeds_sigma(const Autocorrelation& a, std::span<const double> speeds) {
  std::vector<double> reduced(speeds.begin(), speeds.end());
  for (double& v : reduced) v = std::remainder(v, 1.0);
  return sigma_of(a, [&](std::size_t n) {
    double sum = 0;
    for (const double v : reduced) sum += loss(static_cast<double>(n) * v);
    return sum / static_cast<double>(reduced.size());
  });
}

double ipqn_sigma(const Autocorrelation& a) { return std::sqrt(a.r[0] / 12); }

namespace {

/// Within this many quanta per sample every unit interval is searched in full.
constexpr int first_intervals = 8;

class ThresholdSearch {
 public:
  ThresholdSearch(const Autocorrelation& a, double tolerance) : a_(a), tolerance_(tolerance) {
    // Lags that cannot move the ratio by 1e-4 of the tolerance only cost time.
    double rest = 0;
    while (a_.r.size() > 1 && rest + std::abs(a_.r.back()) <= 1e-4 * tolerance * a_.r[0]) {
      rest += std::abs(a_.r.back());
      a_.r.pop_back();
    }
    ipqn_ = ipqn_sigma(a_);
    constexpr int steps = 200;
    const double finest = 0.1 / static_cast<double>(a_.r.size());
    for (int i = 0; i <= steps; ++i) grid_.push_back(0.5 * std::pow(2 * finest, i / double{steps}));
    for (int i = steps; i >= 0; --i) grid_.push_back(-grid_[static_cast<std::size_t>(i)]);
  }

  double find() {
    const double asymptotic = find_asymptotically();
    if (asymptotic > first_intervals)
      for (int p = static_cast<int>(1.02 * asymptotic) + 2; p > first_intervals; --p)
        if (const double v = last_crossing(p, near_limit(p)); v > 0) return v;
    for (int p = first_intervals; p >= 0; --p)
      if (const double v = last_crossing(p, grid_); v > 0) return v;
    return 0;
  }

 private:
  double ratio(double v) const { return slow_sine_sigma(a_, v) / ipqn_; }
  bool outside(double v) const { return std::abs(ratio(v) - 1) > tolerance_; }

  /// How far sigma^2 is off at far + grid, over what the tolerance allows; times sqrt(far/V) elsewhere.
  double find_asymptotically() {
    double largest = 0;
    for (const double part : grid_) {
      const double x = std::pow(ratio(far + part), 2) - 1;
      const double allowed = x > 0 ? tolerance_ * (2 + tolerance_) : tolerance_ * (2 - tolerance_);
      excess_.push_back(std::abs(x) / allowed);
      largest = std::max(largest, excess_.back());
    }
    return std::min(far * largest * largest, 1e9);
  }

  std::vector<double> near_limit(int p) const {
    std::vector<double> parts;
    for (std::size_t i = 0; i < grid_.size(); ++i)
      if (excess_[i] * std::sqrt(far / p) > 0.9) parts.push_back(grid_[i]);
    return parts;
  }

  /// The last V = p + part outside the tolerance, followed to the crossing beyond it; 0 when there is none.
  double last_crossing(int p, const std::vector<double>& parts) const {
    for (const double part : parts) {
      double low = p + part;
      if (low <= 0) break;
      if (!outside(low)) continue;
      const auto next = std::find(grid_.begin(), grid_.end(), part);
      double high = next == grid_.begin() ? low + 1e-3 : p + *(next - 1);
      if (outside(high)) return high;
      for (int i = 0; i < 50; ++i) (outside(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
      return high;
    }
    return 0;
  }

  static constexpr double far = 4096;
  Autocorrelation a_;
  double tolerance_, ipqn_ = 0;
  std::vector<double> grid_;  // of V mod 1, descending from 1/2 to -1/2, finest at 0
  std::vector<double> excess_;
};

}  // namespace

double ipqn_threshold(const Autocorrelation& a, double tolerance) {
  return ThresholdSearch(a, tolerance).find();
}

}  // namespace qerr
