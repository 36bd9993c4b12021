#include "filter/frequency_response.hpp"

#include <cmath>
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

}  // namespace qerr
