#include <algorithm>
#include <cmath>
#include <numbers>

#include "filter/corners.hpp"
#include "filter/design/polynomial.hpp"
#include "filter/frequency_response.hpp"
#include "qerr/filter/quality.hpp"

namespace qerr {
namespace {

using std::numbers::pi;
constexpr int most_steps = 200000;  // about 0.3 s for a filter of order 20
constexpr double rounding = 1e-14;  // relative step at which a crossing has been reached

/// How fast |H|/f^d can fall, theta = 2 pi f T, from its roots.
///
/// ln|e^{j theta} - z| changes by at most delta/r over a step delta for a pole at the distance r; for a zero
/// by at most -ln(1 - delta/r) <= 2 ln 2 delta/r for delta <= r/2. A zero at z = 1 goes with one factor f:
/// |1 - z^-1|/theta = sin(theta/2)/(theta/2), whose logarithm falls by at most 1/pi per radian.
class Descent {
 public:
  explicit Descent(const Filter& filter) : corners_(corners(filter)), derivative_(filter.derivative) {
    nyquist_zeros_ = static_cast<double>(corners_.poles.size()) - static_cast<double>(corners_.zeros.size());
    for (auto* roots : {&corners_.zeros, &corners_.poles})  // z = 0 and infinity have no effect on |H|
      std::erase_if(*roots, [](const std::complex<double>& w) { return w == 0.0 || w == 1.0 || w == -1.0; });
    if (filter.taps.empty()) return;
    const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(filter.taps);
    double total = 0, weighted = 0;
    for (std::size_t k = 0; k < d.quotient.size(); ++k) {
      total += std::abs(d.quotient[k].hi);
      weighted += static_cast<double>(k) * std::abs(d.quotient[k].hi);
    }
    for (std::size_t k = 0; k < d.quotient.size(); ++k)
      taps_slope_ += std::abs(static_cast<double>(k) - weighted / total) * std::abs(d.quotient[k].hi);
    taps_slope_ *= std::abs(filter.gain.hi) * std::pow(filter.sample_rate, -d.zeros);
  }

  /// A step in theta over which ln(|H|/f^d) falls by less than `margin`.
  /// @param gain  |H|/(2 pi f)^d at theta
  double step(double theta, double gain, double margin) const {
    const double s = std::sin(0.5 * theta), c = std::cos(0.5 * theta);
    const auto distance = [&](const std::complex<double>& w) {
      return 2 * std::abs(std::complex<double>(0, s) - w * c) / std::abs(1.0 - w);
    };
    double slope = derivative_ / pi, longest = pi;
    const auto zero = [&](double r, double times) {
      slope += times * 2 * std::numbers::ln2 / r;
      longest = std::min(longest, 0.5 * r);
    };
    for (const std::complex<double>& w : corners_.zeros) zero(distance(w), 1);
    for (const std::complex<double>& w : corners_.poles) slope += 1 / distance(w);
    if (nyquist_zeros_ > 0) zero(2 * c, nyquist_zeros_);
    // A sum of taps h_k z^-k, without its mean delay, changes by at most sum |k - mean| |h_k|.
    if (taps_slope_ > 0) zero(gain / taps_slope_, 1);
    return std::min(longest, margin / slope);
  }

 private:
  Corners corners_;
  double derivative_ = 0;
  double nyquist_zeros_ = 0;
  double taps_slope_ = 0;
};

}  // namespace

std::optional<double> bandwidth(const Filter& filter) {
  if (!estimates_its_derivative(filter)) return std::nullopt;
  const FrequencyResponse<double> h(filter);
  const Descent descent(filter);
  const double per_hertz = 2 * pi / filter.sample_rate,
               level = low_frequency_gain(filter) / std::numbers::sqrt2;
  double frequency = 0, gain = low_frequency_gain(filter);
  for (int i = 0; i < most_steps; ++i) {
    const double step = descent.step(per_hertz * frequency, gain, std::log(gain / level)) / per_hertz;
    if (!(step > rounding * frequency)) return frequency;
    frequency += step;
    if (frequency >= 0.5 * filter.sample_rate) return std::nullopt;
    const ComplexOf<double> now = h.over_ideal(frequency);
    gain = std::hypot(now.re, now.im);
  }
  return frequency;
}

}  // namespace qerr
