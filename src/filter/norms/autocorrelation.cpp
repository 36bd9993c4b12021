#include "filter/norms/autocorrelation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/run/cascade.hpp"
#include "qerr/core/error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

/// r_n of a truncated response h: the output for the reversed response as input; by its definition for taps.
std::vector<double> autocorrelation_of(const Filter& filter, const std::vector<double>& h) {
  std::vector<double> r(h.size());
  if (!filter.taps.empty()) {
    for (std::size_t k = 0; k < h.size(); ++k) {
      const double factor = h[k];
      if (factor == 0) continue;
      for (std::size_t n = 0; k + n < h.size(); ++n) r[n] += factor * h[k + n];
    }
    return r;
  }
  Cascade<double> cascade(filter);
  // In the order of increasing |h|, which loses no digits of large lags.
  for (std::size_t n = h.size(); n-- > 0;) r[n] = cascade.step(h[n]);
  return r;
}

/// Samples until the slowest mode has decayed to exp(-40), with a margin for repeated poles.
double expected_memory(const Filter& filter) {
  const double modulus = poles_max_modulus(filter);
  const double order = static_cast<double>(2 * filter.sections.size());
  const double slow = modulus <= 0  ? 0
                      : modulus < 1 ? (40 + 2 * order) / -std::log(std::max(modulus, 1e-3))
                                    : std::numeric_limits<double>::infinity();  // rounded to 1
  return 8 + order + static_cast<double>(filter.taps.size()) + slow;
}

Error too_long(double samples) {
  return Error("cutoff", "the filter's memory is too long for computing its noise in motion",
               "about " + std::to_string(static_cast<long long>(std::min(samples, 1e18))) + " samples",
               "raise the cut-off or lower the sample rate");
}

}  // namespace

Autocorrelation autocorrelation(const Filter& filter) {
  const double most = static_cast<double>(longest_autocorrelation), expected = expected_memory(filter);
  if (!(expected <= most)) throw too_long(expected);
  const double l1 = l1_norm(filter).upper;
  std::vector<double> h = impulse_response(filter, static_cast<std::size_t>(expected));
  double sum = 0, squares = 0;
  // Smallest terms first, so that the difference to the norm keeps its digits.
  for (auto k = h.rbegin(); k != h.rend(); ++k) {
    sum += std::abs(*k);
    squares += *k * *k;
  }
  Autocorrelation a{autocorrelation_of(filter, h), dc_gain(filter), l1 * std::max(l1 - sum, 0.0)};
  double truncated = 0;
  while (a.r.size() > 1 && truncated + std::abs(a.r.back()) <= 1e-12 * squares) {
    truncated += std::abs(a.r.back());
    a.r.pop_back();
  }
  a.tail += truncated;
  return a;
}

std::optional<Autocorrelation> autocorrelation_within(const Filter& filter, std::size_t longest) {
  if (!(expected_memory(filter) <= static_cast<double>(std::min(longest, longest_autocorrelation))))
    return std::nullopt;
  return autocorrelation(filter);
}

std::vector<double> noise_transient(const Filter& filter, std::size_t count, std::size_t every) {
  std::vector<double> sigma(count);
  double sum = 0;
  const auto run = [&](auto cascade) {
    for (std::size_t k = 0; k < count * every; ++k) {
      const double h = static_cast<double>(cascade.step(k == 0 ? 1.0 : 0.0));
      sum += h * h;
      if (k % every == 0) sigma[k / every] = std::sqrt(sum);
    }
  };
  if (every == 1)
    run(Cascade<DoubleDouble>(filter));
  else
    run(Cascade<double>(filter));
  return sigma;
}

std::optional<double> noise_rise_time(const Filter& filter, double fraction) {
  const double level = std::pow(fraction * h2_norm(filter), 2);
  Cascade<double> cascade(filter);
  double sum = 0;
  for (std::size_t k = 0; k < std::size_t{1} << 22; ++k) {
    const double h = cascade.step(k == 0 ? 1.0 : 0.0);
    sum += h * h;
    if (sum >= level) return static_cast<double>(k) / filter.sample_rate;
  }
  return std::nullopt;
}

}  // namespace qerr
