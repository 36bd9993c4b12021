#include "qerr/filter/filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "filter/design/polynomial.hpp"
#include "filter/norms/modes.hpp"
#include "filter/run/cascade.hpp"

namespace qerr {
namespace {

using Complex = std::complex<double>;

Complex section_response(const Section& section, Complex w) {
  const auto doubles = [](const std::array<DoubleDouble, 3>& c) {
    return std::array{c[0].hi, c[1].hi, c[2].hi};
  };
  const struct { std::array<double, 3> b, a; } s{doubles(section.b), doubles(section.a)};
  if (std::abs(w) <= 1) return (s.b[0] + w * (s.b[1] + w * s.b[2])) / (s.a[0] + w * (s.a[1] + w * s.a[2]));
  // Near the Nyquist frequency in v = 1/w, which is 0 there.
  const Complex v = 1.0 / w;
  if (s.a[2] == 0) return (s.b[0] * v + s.b[1]) / (s.a[0] * v + s.a[1]);
  return (s.b[2] + v * (s.b[1] + v * s.b[0])) / (s.a[2] + v * (s.a[1] + v * s.a[0]));
}

/// Zeros at z = 1 are kept as factors: at low frequencies the sum of the taps would cancel.
/// @param cycles  per sample
Complex taps_response(const std::vector<double>& taps, double cycles, Complex w) {
  const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(taps);
  Complex sum = 0;
  for (std::size_t k = 0; k < d.quotient.size(); ++k) {
    const double part = std::remainder(cycles * static_cast<double>(k), 1.0);
    sum += static_cast<double>(d.quotient[k]) * std::polar(1.0, -2 * std::numbers::pi * part);
  }
  const Complex difference = std::abs(w) <= 1 ? 2.0 * w / (1.0 + w) : 2.0 / (1.0 + 1.0 / w);
  for (int i = 0; i < d.zeros; ++i) sum *= difference;
  return sum;
}

double taps_delay(const std::vector<double>& taps) {
  const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(taps);
  DoubleDouble weighted;
  double size = 0;
  for (std::size_t k = 0; k < d.quotient.size(); ++k) {
    const DoubleDouble part = DoubleDouble(static_cast<double>(k)) * d.quotient[k];
    weighted += part;
    size += std::abs(part.hi);
  }
  const DoubleDouble total = sum(d.quotient);
  if (total.hi == 0) return 0.5 * d.zeros;
  const double delay = 0.5 * d.zeros + static_cast<double>(weighted / total);
  // A delay within the rounding of the taps is 0.
  const double rounding = std::numeric_limits<double>::epsilon() * static_cast<double>(d.quotient.size());
  return std::abs(delay) <= rounding * (0.5 * d.zeros + size / std::abs(total.hi)) ? 0 : delay;
}

/// c1/c0 of the polynomial without its zeros at w = 0.
DoubleDouble relative_slope(const std::array<DoubleDouble, 3>& c) {
  if (c[0] != 0) return c[1] / c[0];
  return c[1] != 0 ? c[2] / c[1] : DoubleDouble(0);
}

}  // namespace

Section section_in_w(const std::array<double, 3>& b, const std::array<double, 3>& a) {
  const auto in_w = [second = b[2] != 0 || a[2] != 0](const std::array<double, 3>& c) {
    const DoubleDouble c0 = c[0], c1 = c[1], c2 = c[2];
    return second ? std::array<DoubleDouble, 3>{c0 + c1 + c2, DoubleDouble(2) * (c0 - c2), c0 - c1 + c2}
                  : std::array<DoubleDouble, 3>{c0 + c1, c0 - c1, 0};
  };
  return {in_w(b), in_w(a)};
}

Complex response(const Filter& filter, double frequency_hz) {
  const double cycles = std::remainder(frequency_hz / filter.sample_rate, 1.0);
  const Complex w(0, std::tan(std::numbers::pi * cycles));
  Complex h = static_cast<double>(filter.gain);
  for (const Section& s : filter.sections) h *= section_response(s, w);
  if (!filter.taps.empty()) h *= taps_response(filter.taps, cycles, w);
  return h;
}

double dc_gain(const Filter& filter) {
  DoubleDouble h = filter.gain;
  for (const Section& s : filter.sections) h *= s.b[0] / s.a[0];
  if (!filter.taps.empty()) {
    const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(filter.taps);
    h *= d.zeros > 0 ? DoubleDouble(0) : sum(d.quotient);
  }
  return static_cast<double>(h);
}

double group_delay(const Filter& filter) {
  DoubleDouble samples;
  double size = 0;
  for (const Section& s : filter.sections) {
    const DoubleDouble below = relative_slope(s.a), above = relative_slope(s.b);
    samples += (below - above) * DoubleDouble(0.5);
    size += std::abs(below.hi) + std::abs(above.hi);
  }
  if (std::abs(samples.hi) <= 1e-27 * size) samples = 0;  // within rounding
  const double total = static_cast<double>(samples) + (filter.taps.empty() ? 0 : taps_delay(filter.taps));
  return total / filter.sample_rate;
}

double poles_max_modulus(const Filter& filter) {
  double largest = 0;
  for (const Pole& pole : poles(filter).list) {
    largest = std::max(largest, static_cast<double>(sqrt(norm(pole.z()))));
  }
  return largest;
}

std::vector<double> impulse_response(const Filter& filter, std::size_t count, std::size_t every) {
  std::vector<double> h(count);
  const auto run = [&](auto cascade) {
    for (std::size_t k = 0; k < count * every; ++k) {
      const auto value = cascade.step(k == 0 ? 1.0 : 0.0);
      if (k % every == 0) h[k / every] = static_cast<double>(value);
    }
  };
  if (every == 1)
    run(Cascade<DoubleDouble>(filter));
  else
    run(Cascade<double>(filter));
  return h;
}

}  // namespace qerr
