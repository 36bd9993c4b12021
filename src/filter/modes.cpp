#include "modes.hpp"

#include <algorithm>

namespace qerr {
namespace {

using Series = std::vector<WideComplex>;  // power series in eta, truncated

void add(std::vector<Pole>& list, WideComplex w) {
  const auto same = std::find_if(list.begin(), list.end(), [&](const Pole& p) { return p.w == w; });
  if (same == list.end()) {
    list.push_back({w, 1});
  } else {
    ++same->multiplicity;
  }
}

void add_section(std::vector<Pole>& list, const Section& s) {
  const Wide a0 = s.a[0], a1 = s.a[1], a2 = s.a[2];
  if (s.a[2] == 0) {
    if (s.a[1] != 0) add(list, -a0 / a1);
    return;
  }
  const Wide discriminant = a1 * a1 - Wide(4) * a0 * a2;
  if (discriminant < Wide(0)) {
    add(list, {-a1 / (Wide(2) * a2), abs(sqrt(-discriminant) / (Wide(2) * a2))});
    return;
  }
  // The larger root by the formula without cancellation, the smaller one from the product.
  const Wide large = (a1 + (a1 < Wide(0) ? -sqrt(discriminant) : sqrt(discriminant))) * Wide(-0.5);
  add(list, large / a2);
  add(list, a0 / large);
}

Series multiplied(const Series& x, const Series& y) {
  Series r(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < y.size() && i + j < r.size(); ++j) r[i + j] = r[i + j] + x[i] * y[j];
  }
  return r;
}

/// x / (y0 + y1 eta).
Series divided(Series x, WideComplex y0, WideComplex y1) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i > 0) x[i] = x[i] - y1 * x[i - 1];
    x[i] = x[i] / y0;
  }
  return x;
}

/// Numerator of a section at w = (w0 + eta)/(1 - eta), times (1 - eta)^order.
Series numerator(const Section& s, WideComplex w0) {
  const WideComplex b0(s.b[0]), b1(s.b[1]), b2(s.b[2]), one(1.0), two(2.0);
  if (s.a[2] == 0) {
    if (s.a[1] == 0) return {b0 / WideComplex(s.a[0])};
    return {b0 + b1 * w0, b1 - b0};
  }
  return {b0 + (b1 + b2 * w0) * w0, b1 * (one - w0) + two * (b2 * w0 - b0), b0 - b1 + b2};
}

/// Divides by (w - pole)^multiplicity, leaving out the factor eta^multiplicity of the expansion's own pole.
Series over_pole(Series x, WideComplex pole, int multiplicity, WideComplex w0, double& condition) {
  const WideComplex one(1.0), gap = w0 - pole;
  const bool own = pole == w0;
  if (!own) condition = std::max(condition, magnitude(w0) / magnitude(gap));
  for (int i = 0; i < multiplicity; ++i) {
    x = own ? divided(std::move(x), one + w0, {}) : divided(std::move(x), gap, one + pole);
  }
  return x;
}

/// The coefficients of one pole. With eta = (1 - z0 q)(1 - w0)/2 the filter is a ratio of polynomials in eta,
/// and w - w_r becomes (w0 - w_r) + (1 + w_r) eta: differences of poles are taken in w, where slow poles keep
/// their digits.
Mode mode_of(const Filter& filter, const std::vector<Pole>& all, const Pole& pole, double& condition) {
  const WideComplex w0 = pole.w, one(1.0);
  Series series(static_cast<std::size_t>(pole.multiplicity));
  series[0] = WideComplex(filter.gain);
  for (const Section& s : filter.sections) {
    series = multiplied(series, numerator(s, w0));
    const Wide lead = s.a[2] != 0 ? s.a[2] : s.a[1];
    if (lead != 0) {
      for (WideComplex& x : series) x = x / WideComplex(lead);
    }
  }
  for (const Pole& other : all) {
    series = over_pole(std::move(series), other.w, other.multiplicity, w0, condition);
    if (!other.real())
      series = over_pole(std::move(series), conj(other.w), other.multiplicity, w0, condition);
  }
  Mode mode;
  mode.z = pole.z();
  mode.one_minus_z = WideComplex(-2.0) * w0 / (one - w0);
  mode.pair = !pole.real();
  mode.c.resize(series.size());
  const WideComplex scale = WideComplex(2.0) / (one - w0);
  WideComplex power = one;
  for (std::size_t m = 1; m <= series.size(); ++m) {
    power = power * scale;
    mode.c[m - 1] = series[series.size() - m] * power;
  }
  return mode;
}

}  // namespace

std::vector<Pole> poles(const Filter& filter) {
  std::vector<Pole> list;
  for (const Section& s : filter.sections) add_section(list, s);
  return list;
}

Modes partial_fractions(const Filter& filter) {
  const std::vector<Pole> all = poles(filter);
  Modes result;
  result.from = 1;
  for (const Pole& pole : all) {
    if (pole.w == WideComplex(-1.0)) {
      result.from += static_cast<std::size_t>(pole.multiplicity);
    } else {
      result.modes.push_back(mode_of(filter, all, pole, result.condition));
    }
  }
  return result;
}

}  // namespace qerr
