#include "qerr/filter/quality.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "filter/norms/sequence.hpp"
#include "filter/run/cascade.hpp"

namespace qerr {

namespace {

using std::numbers::pi;
constexpr double long_memory = 20000;  // [samples] above, modes are faster than samples
constexpr double most_samples = 2e6;

/// H / (j 2 pi f)^d.
std::complex<double> normalised(const Filter& filter, double f) {
  std::complex<double> h = response(filter, f);
  for (int i = 0; i < filter.derivative; ++i) h /= std::complex<double>(0, 2 * pi * f);
  return h;
}

/// Weights of k^d/d! as a sum of binomials C(k - j + d, d), j = 0..d, the repeated sums of a step: Eulerian
/// numbers over d!.
std::vector<double> ramp_weights(int derivative) {
  std::vector<double> weights{1};
  for (int d = 1; d <= derivative; ++d) {
    std::vector<double> next(static_cast<std::size_t>(d) + 1);
    for (std::size_t j = 1; j < next.size(); ++j) {
      const double m = static_cast<double>(j);
      if (j < weights.size()) next[j] += m * weights[j] / d;
      next[j] += (d + 1 - m) * weights[j - 1] / d;
    }
    weights = next;
  }
  return weights;
}

/// The first sample from which the estimate is within `fraction` of its limit, sample by sample.
std::optional<double> settling_by_samples(const Filter& filter, double fraction, double samples) {
  Cascade<double> cascade(filter);
  const std::vector<double> weights = ramp_weights(filter.derivative);
  // Repeated sums of the impulse response stay near 1; the response to t^d/d! itself would grow.
  std::vector<double> sums(static_cast<std::size_t>(filter.derivative) + 1), last(weights.size());
  double settled = 0;
  for (double k = 0; k < samples; ++k) {
    double value = cascade.step(k == 0 ? 1.0 : 0.0);
    for (std::size_t i = 0; i < sums.size(); ++i)
      value = sums[i] += i == 0 ? value : value / filter.sample_rate;
    std::rotate(last.begin(), last.end() - 1, last.end());
    last.front() = value;
    const double estimate = std::inner_product(weights.begin(), weights.end(), last.begin(), 0.0);
    if (!(std::abs(estimate - 1) <= fraction)) settled = k + 1;
  }
  if (settled + 1 >= samples) return std::nullopt;
  return settled;
}

/// The same for slow filters, from their modes: the error of the estimate is the (d + 1)-fold sum of the
/// impulse response from k on, itself a sum of modes. Empty when an oscillation is too fast for 2e5 steps.
std::optional<double> settling_by_modes(const Filter& filter, double fraction) {
  const Modes modes = partial_fractions(filter, poles(filter).list);
  const Powers powers(modes.modes);
  Sequence deficit(modes.modes, powers);
  for (int i = 0; i <= filter.derivative; ++i) deficit = deficit.transient_of_sum();
  const double unit = std::pow(filter.sample_rate, filter.derivative);
  const double final_error = std::abs(low_frequency_gain(filter) - 1);
  if (final_error > fraction) return std::nullopt;
  std::int64_t end = 64;
  while (deficit.bound(end, end) > (fraction - final_error) * unit && end < (std::int64_t{1} << 48)) end *= 2;
  double fastest = 0;
  for (const Mode& mode : modes.modes)
    fastest =
        std::max(fastest, std::abs(std::arg(std::complex<double>(mode.z.re.mid().hi, mode.z.im.mid().hi))));
  // Steps of a hundredth of a period of the fastest oscillation, and of 1/2000 of the decay.
  const double length = static_cast<double>(end);
  const double longest = std::min(length / 2000, 0.06 / std::max(fastest, 1e-300));
  if (length > 2e5 * longest) return std::nullopt;
  const auto step = std::max<std::int64_t>(1, static_cast<std::int64_t>(longest));
  const std::vector<double> weights = ramp_weights(filter.derivative);
  const auto outside = [&](std::int64_t k) {
    double error = 0;
    for (std::size_t j = 0; j < weights.size(); ++j)
      error +=
          weights[j] *
          static_cast<double>(deficit.at(std::max<std::int64_t>(0, k - static_cast<std::int64_t>(j))).mid());
    return !(std::abs(error) <= fraction * unit);
  };
  std::int64_t k = end;
  while (k > 0 && !outside(k)) k -= step;
  if (k <= 0) return 0;
  std::int64_t low = k, high = k + step;
  while (high - low > 1) (outside((low + high) / 2) ? low : high) = (low + high) / 2;
  return static_cast<double>(high);
}

}  // namespace

double low_frequency_gain(const Filter& filter) {
  return std::abs(normalised(filter, 1e-9 * filter.sample_rate));
}

bool estimates_its_derivative(const Filter& filter) {
  const double gain = low_frequency_gain(filter);
  return gain > 0.5 && gain < 2;
}

Fidelity fidelity(const Filter& filter, double f) {
  const std::complex<double> h = normalised(filter, f);
  return {f, std::abs(h) - 1, std::arg(h), std::abs(h - 1.0)};
}

BandTracking band_tracking(const Filter& filter, double from, double to) {
  constexpr int intervals = 2000;  // Simpson's rule over a smooth function
  BandTracking t;
  double sum = 0;
  for (int i = 0; i <= intervals; ++i) {
    const double error = fidelity(filter, from + (to - from) * i / intervals).tracking_error;
    t.largest = std::max(t.largest, error);
    sum += error * error * (i == 0 || i == intervals ? 1 : i % 2 ? 4 : 2);
  }
  t.rms = std::sqrt(sum / (3 * intervals));
  return t;
}

std::optional<double> bandwidth(const Filter& filter) {
  const double reference = low_frequency_gain(filter);
  if (!estimates_its_derivative(filter)) return std::nullopt;
  const double level = reference / std::numbers::sqrt2;
  const auto above = [&](double f) { return std::abs(normalised(filter, f)) > level; };
  // Steps of 1 % in frequency bracket the crossing of a realistic filter; bisection refines it.
  double low = 1e-8 * filter.sample_rate;
  for (double high = low; low < 0.5 * filter.sample_rate; low = high) {
    high = std::min(1.01 * low, 0.5 * filter.sample_rate);
    if (above(high)) {
      if (high == 0.5 * filter.sample_rate) break;
      continue;
    }
    for (int i = 0; i < 60; ++i) (above(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
  }
  return std::nullopt;
}

double noise_bandwidth(const Filter& filter, double h2) {
  const int d = filter.derivative;
  const double power = (2 * d + 1) * 0.5 * filter.sample_rate * h2 * h2 / std::pow(2 * pi, 2 * d);
  return std::pow(power, 1.0 / (2 * d + 1));
}

std::optional<double> settling_time(const Filter& filter, double fraction) {
  const double modulus = poles_max_modulus(filter);
  // All transients have decayed by exp(-60) after this many samples, up to polynomial factors of repeated
  // poles.
  const double samples = 64 + static_cast<double>(filter.taps.size() + 8 * filter.sections.size()) +
                         (modulus < 1 ? 60 / -std::log(std::max(modulus, 0.5)) : INFINITY);
  std::optional<double> settled;
  if (samples > long_memory) settled = settling_by_modes(filter, fraction);
  if (!settled && samples <= most_samples) settled = settling_by_samples(filter, fraction, samples);
  if (!settled) return std::nullopt;
  return *settled / filter.sample_rate;
}

std::vector<std::array<double, 6>> second_order_sections(const Filter& filter) {
  std::vector<std::array<double, 6>> sections;
  for (const Section& s : filter.sections) {
    // w = (1 - q)/(1 + q), numerator and denominator times (1 + q) to the section's order.
    const bool second = s.a[2] != 0 || s.b[2] != 0;
    const auto in_z = [&](const std::array<DoubleDouble, 3>& c) {
      return second ? std::array<DoubleDouble, 3>{c[0] + c[1] + c[2], DoubleDouble(2) * (c[0] - c[2]),
                                                  c[0] - c[1] + c[2]}
                    : std::array<DoubleDouble, 3>{c[0] + c[1], c[0] - c[1], 0};
    };
    const auto b = in_z(s.b), a = in_z(s.a);
    const auto over = [&](DoubleDouble c) { return static_cast<double>(c / a[0]); };
    sections.push_back({over(b[0]), over(b[1]), over(b[2]), 1, over(a[1]), over(a[2])});
  }
  if (sections.empty()) sections.push_back({1, 0, 0, 1, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) sections.front()[i] *= static_cast<double>(filter.gain);
  return sections;
}

}  // namespace qerr
