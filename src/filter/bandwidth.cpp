#include "filter/bandwidth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "filter/design/polynomial.hpp"
#include "filter/frequency_response.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

using Root = std::complex<double>;

/// Both roots in w of a polynomial of a section; fewer where its order is lower.
std::vector<Root> roots_in_w(const std::array<DoubleDouble, 3>& c) {
  const double c0 = c[0].hi, c1 = c[1].hi, c2 = c[2].hi;
  if (c2 == 0) return c1 == 0 ? std::vector<Root>{} : std::vector<Root>{-c0 / c1};
  const Root discriminant = std::sqrt(Root(static_cast<double>(c[1] * c[1] - DoubleDouble(4) * c[0] * c[2])));
  // The larger root by the formula without cancellation, the smaller one from the product.
  const Root large = -0.5 * (c1 < 0 ? c1 - discriminant : c1 + discriminant);
  if (large == 0.0) return {0.0, 0.0};
  return {c0 / large, large / c2};
}

/// Zeros slower than this, relative to the slowest pole, are due to the rounding of coefficients: taken to be
/// at 0 Hz. Between them and the slowest pole the filter estimates its derivative over twelve decades.
constexpr double at_dc = 1e-12;

}  // namespace

Corners corners(const Filter& filter) {
  Corners c;
  for (const Section& s : filter.sections) {
    for (const Root& w : roots_in_w(s.b)) c.zeros.push_back(w);
    for (const Root& w : roots_in_w(s.a)) c.poles.push_back(w);
  }
  for (const Root& w : c.poles) c.slowest_pole = std::min(c.slowest_pole, std::abs(w));
  return c;
}

double limit_at_dc(const Filter& filter) {
  const double slowest = at_dc * corners(filter).slowest_pole;
  DoubleDouble limit = filter.gain;
  int zeros = 0;
  for (const Section& s : filter.sections) {
    std::size_t lead = 0;
    for (const Root& w : roots_in_w(s.b)) lead += std::abs(w) <= slowest ? 1 : 0;
    if (s.b[lead] == 0) return 0;
    zeros += static_cast<int>(lead);
    limit *= s.b[lead] / s.a[0];
    if (static_cast<int>(lead) > 0) limit *= DoubleDouble(std::ldexp(1.0, -static_cast<int>(lead)));
  }
  if (!filter.taps.empty()) {
    const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(filter.taps);
    limit *= sum(d.quotient);
    zeros += d.zeros;
  }
  if (limit == 0 || zeros > filter.derivative) return 0;
  if (zeros < filter.derivative) return std::copysign(std::numeric_limits<double>::infinity(), limit.hi);
  for (int i = 0; i < zeros; ++i) limit = limit / DoubleDouble(filter.sample_rate);
  return static_cast<double>(limit);
}

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
