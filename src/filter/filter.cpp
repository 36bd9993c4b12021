#include "qerr/filter/filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/design/polynomial.hpp"
#include "filter/frequency_response.hpp"
#include "filter/norms/modes.hpp"
#include "filter/run/cascade.hpp"

namespace qerr {
namespace {

double taps_delay(const std::vector<DoubleDouble>& taps) {
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

std::complex<double> response(const Filter& filter, double frequency_hz) {
  const ComplexOf<double> h = FrequencyResponse<double>(filter).at(frequency_hz);
  return {h.re, h.im};
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

bool has_unknown_unit(const Filter& f) {
  constexpr double rounded = 0.01;  // coefficients as people write them
  return !f.unit && f.derivative == 0 && !f.designed && std::abs(dc_gain(f) - 1) > rounded;
}

Dimension output_dimension(const Dimension& input, const Filter& f) {
  const Dimension gain = f.unit.value_or(Dimension{.second = -f.derivative});
  return {input.metre + gain.metre, input.radian + gain.radian, input.second + gain.second,
          input.newton + gain.newton, input.kelvin + gain.kelvin};
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
  if (!filter.taps.empty()) {
    for (std::size_t k = 0; k < count && k * every < filter.taps.size(); ++k)
      h[k] = static_cast<double>(filter.taps[k * every] * filter.gain);
    return h;
  }
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
