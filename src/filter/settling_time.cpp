#include <algorithm>
#include <cmath>
#include <numeric>

#include "filter/corners.hpp"
#include "filter/norms/sequence.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/quality.hpp"

namespace qerr {
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

}  // namespace qerr
