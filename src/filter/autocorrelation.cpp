#include "qerr/filter/autocorrelation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>

#include "qerr/core/error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

using Complex = std::complex<double>;

/// Decimation in time, in place; the size is a power of two. Forward; |.|^2 needs no inverse of its own.
void fourier(std::vector<Complex>& x) {
  const std::size_t size = x.size();
  for (std::size_t i = 1, j = 0; i < size; ++i) {
    std::size_t bit = size >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(x[i], x[j]);
  }
  std::vector<Complex> root(size / 2);
  for (std::size_t i = 0; i < root.size(); ++i)
    root[i] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size));
  for (std::size_t half = 1; half < size; half *= 2)
    for (std::size_t start = 0; start < size; start += 2 * half)
      for (std::size_t i = 0; i < half; ++i) {
        const Complex w = root[i * (size / (2 * half))], b = x[start + half + i];
        const Complex odd{w.real() * b.real() - w.imag() * b.imag(),
                          w.real() * b.imag() + w.imag() * b.real()};
        x[start + half + i] = x[start + i] - odd;
        x[start + i] += odd;
      }
}

std::vector<double> correlated(const std::vector<double>& h) {
  std::vector<Complex> x(std::bit_ceil(2 * h.size()));
  std::copy(h.begin(), h.end(), x.begin());
  fourier(x);
  for (Complex& c : x) c = std::norm(c);
  fourier(x);  // of an even sequence: forward and inverse differ by the factor alone
  std::vector<double> r(h.size());
  for (std::size_t n = 0; n < r.size(); ++n) r[n] = x[n].real() / static_cast<double>(x.size());
  return r;
}

/// Samples after which exp(-40) is left of the slowest mode, with some room for repeated poles.
double expected_memory(const Filter& filter) {
  const double modulus = poles_max_modulus(filter);
  const double order = static_cast<double>(2 * filter.sections.size());
  const double slow = modulus > 0 ? (40 + 2 * order) / -std::log(std::max(modulus, 1e-3)) : 0;
  return 8 + order + static_cast<double>(filter.taps.size()) + slow;
}

Error too_long(double samples) {
  return Error({{},
                "cutoff",
                "the filter remembers too many samples for its noise in motion to be computed",
                "about " + std::to_string(static_cast<long long>(std::min(samples, 1e18))) + " samples",
                "raise the cut-off or lower the sample rate"});
}

}  // namespace

Autocorrelation autocorrelation(const Filter& filter) {
  const double most = static_cast<double>(longest_autocorrelation), expected = expected_memory(filter);
  if (!(expected <= most)) throw too_long(expected);
  const double l1 = l1_norm(filter).upper;
  std::vector<double> h = impulse_response(filter, static_cast<std::size_t>(expected));
  double sum = 0, squares = 0;
  // From the small end, so that the difference to the norm keeps its digits.
  for (auto k = h.rbegin(); k != h.rend(); ++k) {
    sum += std::abs(*k);
    squares += *k * *k;
  }
  Autocorrelation a{correlated(h), dc_gain(filter), l1 * std::max(l1 - sum, 0.0)};
  double rest = 0;
  while (a.r.size() > 1 && rest + std::abs(a.r.back()) <= 1e-12 * squares) {
    rest += std::abs(a.r.back());
    a.r.pop_back();
  }
  a.tail += rest;
  return a;
}

std::optional<Autocorrelation> followed(const Filter& filter, std::size_t longest) {
  if (!(expected_memory(filter) <= static_cast<double>(std::min(longest, longest_autocorrelation))))
    return std::nullopt;
  return autocorrelation(filter);
}

}  // namespace qerr
