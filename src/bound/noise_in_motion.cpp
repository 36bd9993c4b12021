#include "bound/noise_in_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/search.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

using std::numbers::pi;

/// {s}(1 - {s}), for |s| < 2^51. The addition rounds to the nearest integer and, unlike floor, in a vector.
double loss(double s) {
  constexpr double shift = 0x1.8p52;
  const double part = std::abs(s - ((s + shift) - shift));
  return part * (1 - part);
}

/// E {s}(1 - {s}) of a sine of this amplitude: 1/4 - E e^2 of s + 1/2.
double sine_loss(double amplitude, int bits = full_bits) {
  return 0.25 - quantized_sine_mean_square(0.5, amplitude, bits);
}

/// sqrt(H(1)^2/12 - sum r_n loss_of(n)), summed in ascending order of magnitude.
template <class Loss>
double sigma_of(const Autocorrelation& a, Loss loss_of) {
  double sum = 0;
  for (std::size_t n = a.r.size(); n-- > 1;) sum += a.r[n] * loss_of(n);
  return std::sqrt(std::max(0.0, a.dc_gain * a.dc_gain / 12 - sum));
}

/// |H|^2 at a frequency of `part` cycles per sample.
double power(const Filter& filter, double part) {
  return std::norm(response(filter, std::remainder(part, 1.0) * filter.sample_rate));
}

/// Denominator q <= most of the fraction p/q that v equals up to rounding; 0: v is not such a fraction.
int denominator_of(double v, int most) {
  for (int q = 1; q <= most; ++q)
    if (std::abs(std::remainder(q * v, 1.0)) <= 4 * q * std::numeric_limits<double>::epsilon()) return q;
  return 0;
}

/// sum_k |H(k V)|^2/(2 pi^2 k^2), or for V = p/q sum_m |H(m p/q)|^2/(4 q^2 sin^2(pi m/q)) +
/// H(1)^2/(12 q^2). The terms beyond `most` are replaced by their mean over V.
double sigma_by_harmonics(const Filter& filter, double v) {
  constexpr int most = 500000;
  double sum = 0;
  if (const int q = denominator_of(v, 2000); q > 0) {
    const double p = std::round(q * v), parts = q;
    for (int m = 1; m < q; ++m)
      sum +=
          power(filter, std::fmod(m * p, parts) / parts) / std::pow(2 * parts * std::sin(pi * m / parts), 2);
    return std::sqrt(sum + std::pow(dc_gain(filter) / parts, 2) / 12);
  }
  for (int k = most; k > 0; --k) sum += power(filter, k * v) / (2 * pi * pi * k * static_cast<double>(k));
  return std::sqrt(sum + std::pow(h2_norm(filter), 2) / (2 * pi * pi * (most + 0.5)));
}

/// Up to this many quanta per sample every unit interval is searched on the whole grid.
constexpr int first_intervals = 8;

class ThresholdSearch {
 public:
  ThresholdSearch(const Autocorrelation& a, double tolerance) : a_(a), tolerance_(tolerance) {
    // Drop lags that cannot change the ratio by 1e-4 of the tolerance.
    double dropped = 0;
    while (a_.r.size() > 1 && dropped + std::abs(a_.r.back()) <= 1e-4 * tolerance * a_.r[0]) {
      dropped += std::abs(a_.r.back());
      a_.r.pop_back();
    }
    ipqn_ = ipqn_sigma(a_);
    constexpr int steps = 150;
    const double finest = 0.1 / static_cast<double>(a_.r.size());
    for (int i = 0; i <= steps; ++i) grid_.push_back(0.5 * std::pow(2 * finest, i / double{steps}));
    for (int i = steps; i >= 0; --i) grid_.push_back(-grid_[i]);
  }

  double find() {
    const double ceiling = proven_ceiling();
    if (ceiling > first_intervals) {
      const double asymptotic = find_asymptotically();
      for (int p = static_cast<int>(std::min(1.0001 * asymptotic + 3, ceiling + 1)); p > first_intervals; --p)
        if (const double v = last_crossing(p, near_limit(p)); v > 0) return v;
    }
    for (int p = static_cast<int>(std::min(ceiling + 1, double{first_intervals})); p >= 0; --p)
      if (const double v = last_crossing(p, up_to(ceiling - p)); v > 0) return v;
    return 0;
  }

 private:
  double ratio(double v, int bits) const { return slow_sine_sigma(a_, v, bits) / ipqn_; }

  /// By a few bits where they decide, which is faster.
  bool outside(double v) const {
    // The missing bits change a lag's part of the ratio by 12 * 18 * 2^-20/(2 pi^3 sqrt(10)) = 1.1e-6.
    constexpr double doubt = 1e-4;
    const double off = std::abs(ratio(v, few_bits) - 1);
    if (std::abs(off - tolerance_) > doubt) return off > tolerance_;
    return std::abs(ratio(v, full_bits) - 1) > tolerance_;
  }

  /// A speed above which the tolerance holds: |E {s}(1 - {s}) - 1/6| of a sine of amplitude u is at most
  /// 0.0381/sqrt(u) (quantized_sine_envelope), so that |sigma^2/sigma_IPQN^2 - 1| is at most
  /// 12 sum |r_n|/r_0 0.0381/sqrt(n V).
  double proven_ceiling() const {
    constexpr double highest = 1e9;  // intervals are numbered by int
    double sum = 0;
    for (std::size_t n = 1; n < a_.r.size(); ++n)
      sum += std::abs(a_.r[n]) / std::sqrt(static_cast<double>(n));
    const double root = 12 * 0.0381 * sum / (tolerance_ * (2 - tolerance_) * a_.r[0]);
    return root * root < highest ? root * root : std::isnan(root) ? 0 : highest;
  }

  /// |sigma^2/sigma_IPQN^2 - 1| over its limit by the tolerance.
  double excess(double v) const {
    const double x = std::pow(ratio(v, few_bits), 2) - 1;
    return std::abs(x) / (x > 0 ? tolerance_ * (2 + tolerance_) : tolerance_ * (2 - tolerance_));
  }

  /// Computes the excess at far + grid; elsewhere it is sqrt(far/V) times as large.
  /// @returns the V at which its peak is 1
  double find_asymptotically() {
    for (const double part : grid_) excess_.push_back(excess(far + part));
    const auto peak = std::ranges::max_element(excess_);
    const auto peak_index = std::clamp<std::ptrdiff_t>(peak - excess_.begin(), 1, std::ssize(grid_) - 2);
    // Refine the grid at its peak by golden section search.
    double above = grid_[peak_index - 1], below = grid_[peak_index + 1];
    for (int i = 0; i < 20; ++i) {
      const double a = below + 0.382 * (above - below), b = below + 0.618 * (above - below);
      const bool a_is_less = excess(far + a) < excess(far + b);
      (a_is_less ? below : above) = a_is_less ? a : b;
    }
    const double part = 0.5 * (above + below), refined = excess(far + part);
    const auto place = std::ranges::find_if(grid_, [&](double g) { return g < part; });
    excess_.insert(excess_.begin() + (place - grid_.begin()), refined);
    grid_.insert(place, part);
    const double largest = *std::ranges::max_element(excess_);
    return far * largest * largest;
  }

  std::vector<double> near_limit(int p) const {
    std::vector<double> parts;
    for (std::size_t i = 0; i < grid_.size(); ++i)
      if (excess_[i] * std::sqrt(far / p) > 0.9995 - 1.0 / p) parts.push_back(grid_[i]);
    return parts;
  }

  std::vector<double> up_to(double part) const {
    return {std::ranges::find_if(grid_, [&](double g) { return g <= part; }), grid_.end()};
  }

  /// The crossing above the largest V = p + part outside the tolerance; 0: all are within.
  double last_crossing(int p, const std::vector<double>& parts) const {
    for (const double part : parts) {
      const double low = p + part;
      if (low <= 0) break;
      if (!outside(low)) continue;
      const auto next = std::ranges::find(grid_, part);
      const double high = next == grid_.begin() ? low + 1e-3 : p + *(next - 1);
      if (outside(high)) return high;
      return bisect({low, high}, 50, [&](double v) { return outside(v); }).fails;
    }
    return 0;
  }

  static constexpr double far = 4096;
  static constexpr int few_bits = 20;
  Autocorrelation a_;
  double tolerance_, ipqn_ = 0;
  std::vector<double> grid_;  // of V mod 1, descending from 1/2 to -1/2, finest at 0
  std::vector<double> excess_;
};

}  // namespace

double constant_speed_sigma(const Autocorrelation& a, double v) {
  const double speed = std::abs(std::remainder(v, 1.0));
  return sigma_of(a, [&](std::size_t n) { return loss(static_cast<double>(n) * speed); });
}

double constant_speed_sigma(const Filter& filter, double v) {
  if (const auto memory = autocorrelation_within(filter)) return constant_speed_sigma(*memory, v);
  return sigma_by_harmonics(filter, std::remainder(v, 1.0));
}

double sine_sigma(const Autocorrelation& a, double amplitude, double cycles) {
  return sigma_of(a, [&](std::size_t n) {
    return sine_loss(2 * amplitude *
                     std::abs(std::sin(pi * std::remainder(static_cast<double>(n) * cycles, 1.0))));
  });
}

double slow_sine_sigma(const Autocorrelation& a, double peak, int bits) {
  return sigma_of(a, [&](std::size_t n) { return sine_loss(static_cast<double>(n) * std::abs(peak), bits); });
}

double ipqn_sigma(const Autocorrelation& a) { return std::sqrt(a.r[0] / 12); }

std::optional<double> ipqn_threshold(const Autocorrelation& a, double tolerance) {
  if (a.r.size() > longest_threshold_search) return std::nullopt;
  return ThresholdSearch(a, tolerance).find();
}

}  // namespace qerr
