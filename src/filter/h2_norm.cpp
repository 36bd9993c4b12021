#include <algorithm>
#include <cmath>

#include "qerr/core/double_double.hpp"
#include "qerr/core/error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

using Polynomial = std::vector<Wide>;  // ascending in w

Polynomial multiplied(const Polynomial& p, const std::array<Wide, 3>& c, std::size_t order) {
  Polynomial r(p.size() + order);
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j <= order; ++j) r[i + j] += p[i] * c[j];
  }
  return r;
}

std::size_t order_of(const Section& s) { return s.a[2] != 0 ? 2 : (s.a[1] != 0 ? 1 : 0); }

/// (1/2 pi) int |b(j Omega)/a(j Omega)|^2 dOmega, degree of b below that of a (Astrom's recursion); negative
/// if a is unstable.
///
/// Positive terms only: neither the alphas nor the sum can cancel for a stable a.
Wide integral(Polynomial a, Polynomial b) {
  std::reverse(a.begin(), a.end());
  std::reverse(b.begin(), b.end());
  b.insert(b.begin(), a.size() - 1 - b.size(), Wide(0));
  Wide total;
  for (std::size_t n = a.size() - 1; n > 0; --n) {
    const Wide alpha = a[0] / a[1], beta = b[0] / a[1];
    if (!(Wide(0) < alpha)) return -1.0;
    total += beta * beta / (Wide(2) * alpha);
    Polynomial next_a(n), next_b(n - 1);
    for (std::size_t i = 0; i < n; ++i) {
      next_a[i] = a[i + 1];
      if (i % 2 == 1 && i + 2 <= n) next_a[i] = next_a[i] - alpha * a[i + 2];
    }
    for (std::size_t i = 1; i < n; ++i) {
      next_b[i - 1] = b[i];
      if (i % 2 == 0 && i + 1 <= n) next_b[i - 1] = next_b[i - 1] - beta * a[i + 1];
    }
    a = std::move(next_a);
    b = std::move(next_b);
  }
  return total;
}

/// The same integral with w = 2^shift v: the powers of a slow pole neither overflow nor vanish.
int centring_shift(const Polynomial& a) {
  const double ratio = std::log2(std::abs(a.front().hi)) - std::log2(std::abs(a.back().hi));
  return static_cast<int>(std::lround(ratio / static_cast<double>(a.size() - 1)));
}

void stretch(Polynomial& p, int shift) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    const int by = shift * static_cast<int>(i);
    p[i] = {std::ldexp(p[i].hi, by), std::ldexp(p[i].lo, by)};
  }
}

double taps_norm(const std::vector<double>& taps, Wide gain) {
  Wide total;
  for (const double h : taps) total += Wide(h) * Wide(h);
  return static_cast<double>(sqrt(total) * abs(gain));
}

}  // namespace

double h2_norm(const Filter& filter) {
  if (!filter.taps.empty()) return taps_norm(filter.taps, filter.gain);
  // d theta = 2 dOmega/(1 + Omega^2): the measure of the unit circle adds 1 + w to the denominator.
  Polynomial a{1, 1}, b{1};
  for (const Section& s : filter.sections) {
    a = multiplied(a, s.a, order_of(s));
    b = multiplied(b, s.b, order_of(s));
  }
  if (a.front().hi < 0) {
    for (Wide& c : a) c = -c;
  }
  const int shift = centring_shift(a);
  stretch(a, shift);
  stretch(b, shift);
  const Wide squared = Wide(std::ldexp(2.0, shift)) * integral(std::move(a), std::move(b));
  if (!(squared.hi >= 0) || !std::isfinite(squared.hi)) {
    throw Error(Fault{{},
                      "",
                      "the H2 norm needs a stable filter",
                      "an unstable section or coefficients out of range",
                      ""},
                Trouble::internal);
  }
  return static_cast<double>(sqrt(squared) * abs(filter.gain));
}

Norms norms(const Filter& filter) { return {h2_norm(filter), l1_norm(filter), dc_gain(filter)}; }

}  // namespace qerr
