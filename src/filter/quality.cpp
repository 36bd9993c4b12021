#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/search.hpp"
#include "filter/frequency_response.hpp"
#include "filter/norms/sequence.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
double low_frequency_gain(const Filter& filter) { return limit_at_dc(filter); }

bool estimates_its_derivative(const Filter& filter) {
  const double gain = low_frequency_gain(filter);
  return gain > 0.5 && gain < 2;
}

bool passes_slow_motion(const Filter& filter) {
  constexpr double most = 0.01;  // gains of lower ripple change noise by less than other choices do
  return std::abs(low_frequency_gain(filter) - 1) <= most;
}

Fidelity fidelity(const Filter& filter, double f) { return TrackingError(filter).fidelity(f); }

double noise_bandwidth(const Filter& filter, double h2) {
  const int d = filter.derivative;
  const double density = (2 * d + 1) * 0.5 * filter.sample_rate / std::pow(2 * std::numbers::pi, 2 * d);
  return std::pow(density, 1.0 / (2 * d + 1)) * std::pow(h2, 2.0 / (2 * d + 1));
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

namespace {

constexpr double long_memory = 20000;  // [samples] above, modes are faster than samples
constexpr double most_samples = 2e6;
constexpr int most_blocks = 200000;  // about 1 s

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

/// The sample after the last one below `samples` at which the estimate is not within `fraction` of 1.
double settling_by_samples(const Filter& filter, double fraction, double samples) {
  Cascade<double> cascade(filter);
  const std::vector<double> taps = impulse_response(filter, filter.taps.size());
  const std::vector<double> weights = ramp_weights(filter.derivative);
  // Repeated sums of the impulse response stay near 1; the response to t^d/d! itself would grow.
  std::vector<double> sums(static_cast<std::size_t>(filter.derivative) + 1), last(weights.size());
  double settled = 0;
  for (double k = 0; k < samples; ++k) {
    const auto index = static_cast<std::size_t>(k);
    double value = taps.empty() ? cascade.step(k == 0 ? 1.0 : 0.0) : index < taps.size() ? taps[index] : 0;
    for (std::size_t i = 0; i < sums.size(); ++i)
      value = sums[i] += i == 0 ? value : value / filter.sample_rate;
    std::rotate(last.begin(), last.end() - 1, last.end());
    last.front() = value;
    const double estimate = std::inner_product(weights.begin(), weights.end(), last.begin(), 0.0);
    if (!(std::abs(estimate - 1) <= fraction)) settled = k + 1;
  }
  return settled;
}

/// sum_j weights_j x_{k-j}, as differences of x: for a slow filter these are small against x.
Sequence weighted(const Sequence& x, const std::vector<double>& weights) {
  Sequence sum = x, difference = x;
  std::vector<double> binomial(weights.size(), 1);  // C(j, i)
  for (std::size_t i = 1; i < weights.size(); ++i) {
    difference = difference.difference();
    double factor = 0;
    for (std::size_t j = 0; j < weights.size(); ++j) {
      binomial[j] *= (static_cast<double>(j) - static_cast<double>(i) + 1) / static_cast<double>(i);
      factor += (i % 2 == 1 ? -1 : 1) * weights[j] * binomial[j];
    }
    sum = sum.plus(factor, difference);
  }
  return sum;
}

/// Finds the last sample at which |x_k + offset| > limit, by bisection of blocks from the end.
class LastOutside {
 public:
  LastOutside(const Sequence& x, const Powers& powers, double offset, double limit)
      : x_(x), powers_(powers), differences_(x), offset_(offset), limit_(limit) {}

  /// @returns -1 where there is none
  std::int64_t in(std::int64_t first, std::int64_t end) {
    if (++blocks_ > most_blocks) return -1;
    if (x_.bound(first, end - 1) + std::abs(offset_) <= limit_) return -1;
    const std::int64_t middle = first + (end - first) / 2;
    powers_.quick(middle, power_);
    const double size = x_.bound(middle, middle);
    // Quick values have 12 digits of the sum of the modes' sizes.
    double value = std::abs(x_.quick_at(middle, power_) + offset_), uncertainty = 1e-12 * size;
    double change = static_cast<double>(middle - first) * differences_.first().bound(first, end - 1);
    if (uncertainty > 1e-11 * limit_ || (change > 0 && value < 0.1 * size)) {
      const std::vector<ComplexBall> powers = powers_.proven(middle);
      const RealBall fine = x_.at(middle, powers);
      value = std::abs(static_cast<double>(fine.mid()) + offset_);
      uncertainty = fine.rad();
      if (end - first > 1) change = std::min(change, differences_.variation(first, end, middle, powers));
    }
    if (end - first == 1) return value > limit_ ? first : -1;
    if (value + change + uncertainty <= limit_) return -1;
    if (value - change - uncertainty > limit_) return end - 1;
    const std::int64_t later = in(middle, end);
    return later >= 0 ? later : in(first, middle);
  }
  bool finished() const { return blocks_ <= most_blocks; }

 private:
  const Sequence& x_;
  const Powers& powers_;
  Differences differences_;
  std::vector<std::complex<double>> power_;
  double offset_, limit_;
  int blocks_ = 0;
};

/// Settling time of slow filters, from their modes: the error of the estimate is that of its limit plus the
/// (d + 1)-fold sum of the impulse response from k on, itself a sum of modes. Empty where close poles do not
/// allow partial fractions.
std::optional<double> settling_by_modes(const Filter& filter, double fraction) {
  const Modes modes = partial_fractions(filter, poles(filter).list);
  const Powers powers(modes.modes);
  Sequence deficit(modes.modes, powers);
  for (int i = 0; i <= filter.derivative; ++i) deficit = deficit.transient_of_sum();
  const Sequence error = weighted(deficit, ramp_weights(filter.derivative));
  if (!error.accurate()) return std::nullopt;
  const double unit = std::pow(filter.sample_rate, filter.derivative);
  const double offset = (limit_at_dc(filter) - 1) * unit, limit = fraction * unit;
  // The modes hold from modes.from on, their sums from one sample earlier.
  const auto first = static_cast<std::int64_t>(modes.from) + filter.derivative;
  std::int64_t end = 2 * first + 64;
  while (end < latest_sample && error.bound(end, end) + std::abs(offset) > limit) end *= 2;
  if (end >= latest_sample) return std::nullopt;
  LastOutside last(error, powers, offset, limit);
  const std::int64_t found = last.in(first, end);
  if (!last.finished()) return std::nullopt;
  return found >= 0 ? static_cast<double>(found) + 1
                    : settling_by_samples(filter, fraction, static_cast<double>(first));
}

// Gauss and Kronrod, 7 and 15 nodes on [-1, 1] (Piessens et al., QUADPACK, 1983): the nodes above 0, those of
// Gauss at odd indices, and 0.
constexpr std::array<double, 8> nodes{
    0.991455371120812639, 0.949107912342758525, 0.864864423359769073, 0.741531185599394440,
    0.586087235467691130, 0.405845151377397167, 0.207784955007898468, 0};
constexpr std::array<double, 8> kronrod{0.022935322010529225, 0.063092092629978553, 0.104790010322250184,
                                        0.140653259715525919, 0.169004726639267903, 0.190350578064785410,
                                        0.204432940075298892, 0.209482141084727828};
constexpr std::array<double, 4> gauss{0.129484966168869693, 0.279705391489276668, 0.381830050505118945,
                                      0.417959183673469388};
constexpr double wanted = 1e-11;  // relative difference of both rules: Kronrod's is much more accurate
constexpr std::size_t most_panels = 20000;  // about 1 s for a filter of order 20
constexpr double promising = 0.8;  // of the largest value at a node; a resolved peak rises less between nodes

/// A tracking error at a frequency.
struct BandSample {
  double frequency, error;
};

/// A part of the band, and the integral of the squared error over it.
struct Panel {
  double from = 0, to = 0, integral = 0, uncertainty = 0;
  std::array<BandSample, 15> readings{};  // in the order of frequency
};

Panel panel(const TrackingError& tracking, double from, double to) {
  Panel p{from, to, 0, 0, {}};
  const double center = 0.5 * (from + to), half = 0.5 * (to - from);
  double coarse = 0;
  for (std::size_t i = 0; i < 15; ++i) {
    const std::size_t k = std::min(i, 14 - i);
    const double frequency = center + (i < 7 ? -half : half) * nodes[k];
    const double error = tracking(frequency);
    p.readings[i] = {frequency, error};
    p.integral += half * kronrod[k] * error * error;
    if (k % 2 == 1) coarse += half * gauss[k / 2] * error * error;
  }
  p.uncertainty = std::abs(p.integral - coarse);
  return p;
}

/// The ends of the band and, within it, the frequencies at which the response bends: of poles and zeros, and
/// the flanks of resonances.
std::vector<double> breakpoints(const Filter& filter, double from, double to) {
  std::vector<double> list{from, to};
  const Corners c = corners(filter);
  for (const auto* roots : {&c.zeros, &c.poles})
    for (const std::complex<double>& w : *roots)
      for (const double at : {std::abs(w), w.imag() - w.real(), w.imag(), w.imag() + w.real()}) {
        const double frequency = filter.sample_rate / std::numbers::pi * std::atan(at);
        if (frequency > from && frequency < to) list.push_back(frequency);
      }
  // Taps have lobes of the width of the sample rate over their number.
  const auto lobes = static_cast<std::size_t>(std::min(
      (to - from) / filter.sample_rate * static_cast<double>(filter.taps.size()), 0.5 * most_panels));
  for (std::size_t i = 1; i < lobes; ++i)
    list.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(lobes));
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

/// Panels over the whole band, halved where both rules differ, until they agree.
std::vector<Panel> resolved(const Filter& filter, const TrackingError& tracking, double from, double to) {
  std::vector<Panel> panels;
  const std::vector<double> breaks = breakpoints(filter, from, to);
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    panels.push_back(panel(tracking, breaks[i], breaks[i + 1]));
  for (std::size_t before = 0; panels.size() != before && panels.size() < most_panels;) {
    before = panels.size();
    double integral = 0;
    for (const Panel& p : panels) integral += p.integral;
    std::vector<Panel> finer;
    for (const Panel& p : panels) {
      const double middle = 0.5 * (p.from + p.to);
      if (!(p.uncertainty * static_cast<double>(before) > wanted * integral) || middle <= p.from ||
          middle >= p.to) {
        finer.push_back(p);
      } else {
        finer.push_back(panel(tracking, p.from, middle));
        finer.push_back(panel(tracking, middle, p.to));
      }
    }
    panels = std::move(finer);
  }
  return panels;
}

double largest_error(const TrackingError& tracking, const std::vector<Panel>& panels) {
  std::vector<BandSample> all{{panels.front().from, tracking(panels.front().from)}};
  for (const Panel& p : panels) {
    all.insert(all.end(), p.readings.begin(), p.readings.end());
    all.push_back({p.to, tracking(p.to)});
  }
  double largest = 0;
  for (const BandSample& r : all) largest = std::max(largest, r.error);
  const double candidate = promising * largest;
  for (std::size_t i = 1; i + 1 < all.size(); ++i)
    if (all[i].error >= candidate && all[i].error >= all[i - 1].error && all[i].error >= all[i + 1].error)
      largest =
          std::max(largest, golden_section(all[i - 1].frequency, all[i + 1].frequency, 45, tracking).value);
  return largest;
}

}  // namespace

std::optional<double> settling_time(const Filter& filter, double fraction) {
  if (!(std::abs(limit_at_dc(filter) - 1) <= fraction)) return std::nullopt;
  const double modulus = poles_max_modulus(filter);
  // All transients have decayed by exp(-60) after this many samples, up to polynomial factors of repeated
  // poles.
  const double samples = 64 + static_cast<double>(filter.taps.size() + 8 * filter.sections.size()) +
                         (modulus < 1 ? 60 / -std::log(std::max(modulus, 0.5)) : INFINITY);
  std::optional<double> settled;
  if (samples > long_memory && filter.taps.empty()) settled = settling_by_modes(filter, fraction);
  if (!settled && samples <= most_samples) settled = settling_by_samples(filter, fraction, samples);
  if (!settled) return std::nullopt;
  return *settled / filter.sample_rate;
}

BandTracking band_tracking(const Filter& filter, double from, double to) {
  const TrackingError tracking(filter);
  const std::vector<Panel> panels = resolved(filter, tracking, from, to);
  double integral = 0;
  for (const Panel& p : panels) integral += p.integral;
  return {largest_error(tracking, panels), std::sqrt(integral / (to - from))};
}

}  // namespace qerr
