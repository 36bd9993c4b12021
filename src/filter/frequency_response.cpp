#include "filter/frequency_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "filter/design/polynomial.hpp"

namespace qerr {

namespace {

const DoubleDouble double_double_pi{3.141592653589793116, 1.224646799147353207e-16};

/// cos(pi x) and sin(pi x).
template <class Number>
struct Direction {
  Number cosine, sine;
};

/// The sum of (-1)^k x^(2k + first)/(2k + first)!, sine (first 1) or cosine (first 0), |x| <= pi/4.
DoubleDouble taylor(DoubleDouble x, int first) {
  DoubleDouble term = first == 1 ? x : DoubleDouble(1), sum = term;
  const DoubleDouble square = x * x;
  for (int k = first + 2; std::abs(term.hi) > 1e-34 * std::abs(sum.hi); k += 2) {
    term = -term * square / DoubleDouble(k * (k - 1));
    sum += term;
  }
  return sum;
}

Direction<double> direction(double frequency_hz, double sample_rate, double) {
  const double cycles = std::remainder(frequency_hz / sample_rate, 1.0);
  const double from_nyquist = 0.5 - std::abs(cycles);
  return {std::abs(cycles) < 0.25 ? std::cos(std::numbers::pi * cycles)
                                  : std::sin(std::numbers::pi * from_nyquist),
          std::sin(std::numbers::pi * cycles)};
}

Direction<DoubleDouble> direction(double frequency_hz, double sample_rate, DoubleDouble) {
  DoubleDouble cycles = DoubleDouble(frequency_hz) / DoubleDouble(sample_rate);
  cycles -= DoubleDouble(std::round(cycles.hi));
  const DoubleDouble from_nyquist = DoubleDouble(0.5) - abs(cycles);
  const bool low = std::abs(cycles.hi) < 0.25;
  const DoubleDouble x = double_double_pi * (low ? abs(cycles) : from_nyquist);
  const DoubleDouble sine = taylor(x, 1), cosine = taylor(x, 0);
  const DoubleDouble up = low ? sine : cosine;
  return {low ? cosine : sine, cycles < DoubleDouble(0) ? -up : up};
}

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

template <class Number>
FrequencyResponse<Number>::FrequencyResponse(const Filter& filter)
    : sample_rate_(filter.sample_rate),
      derivative_(filter.derivative),
      gain_(static_cast<Number>(filter.gain)) {
  for (const Section& s : filter.sections) {
    NumberSection& n = sections_.emplace_back();
    n.second = !(s.a[2] == 0) || !(s.b[2] == 0);
    for (std::size_t i = 0; i < 3; ++i) {
      n.b[i] = static_cast<Number>(s.b[i]);
      n.a[i] = static_cast<Number>(s.a[i]);
    }
  }
  if (filter.taps.empty()) return;
  const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(filter.taps);
  differences_ = d.zeros;
  for (const DoubleDouble& c : d.quotient) taps_.push_back(static_cast<Number>(c));
}

template <class Number>
ComplexOf<Number> FrequencyResponse<Number>::product(double frequency_hz, int divisions) const {
  const Number omega = static_cast<Number>(DoubleDouble(2 * frequency_hz) * double_double_pi);
  const auto [c, s] = direction(frequency_hz, sample_rate_, Number());
  const Number square = c * c, below = s * s, cross = s * c;
  ComplexOf<Number> h(gain_);
  const auto multiply = [&](const ComplexOf<Number>& factor) {
    h = h * factor;
    if (divisions-- > 0) h = {h.im / omega, -h.re / omega};
  };
  for (const NumberSection& n : sections_) {
    // Clang 14 does not capture structured bindings by reference.
    const auto in_w = [&, c = c, s = s](const Number* p) -> ComplexOf<Number> {
      if (!n.second) return {p[0] * c, p[1] * s};
      return {p[0] * square - p[2] * below, p[1] * cross};
    };
    multiply(in_w(n.b) / in_w(n.a));
  }
  const ComplexOf<Number> half_sample(c, -s), sample = half_sample * half_sample;
  for (int i = 0; i < differences_; ++i) multiply(ComplexOf<Number>(Number(0), s + s) * half_sample);
  if (!taps_.empty()) {
    ComplexOf<Number> sum;
    for (std::size_t k = taps_.size(); k-- > 0;) {
      sum = sum * sample;
      sum.re += taps_[k];
    }
    multiply(sum);
  }
  while (divisions > 0) multiply(ComplexOf<Number>(Number(1)));
  return h;
}

template <class Number>
ComplexOf<Number> FrequencyResponse<Number>::at(double frequency_hz) const {
  return product(frequency_hz, 0);
}

template <class Number>
ComplexOf<Number> FrequencyResponse<Number>::over_ideal(double frequency_hz) const {
  return product(frequency_hz, derivative_);
}

template class FrequencyResponse<double>;
template class FrequencyResponse<DoubleDouble>;

double TrackingError::operator()(double f) const {
  const ComplexOf<double> h = quick_.over_ideal(f);
  const double error = std::hypot(h.re - 1, h.im);
  return error > 1e-3 ? error : fidelity(f).tracking_error;
}

Fidelity TrackingError::fidelity(double f) const {
  const ComplexDoubleDouble h = fine_.over_ideal(f);
  const DoubleDouble one = 1, error = h.re - one, square = h.im * h.im;
  // |h| - 1 = (|h|^2 - 1)/(|h| + 1)
  const DoubleDouble gain = (error * (h.re + one) + square) / (sqrt(norm(h)) + one);
  return {f, static_cast<double>(gain), std::atan2(h.im.hi, h.re.hi), std::hypot(error.hi, h.im.hi)};
}

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
