#include "filter/design/families/families.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/lists.hpp"
#include "filter/design/polynomial.hpp"
#include "filter/norms/multiprecision.hpp"

namespace qerr {

std::string figure(double value) {
  std::array<char, 64> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 12);
  return {text.data(), end.ptr};
}

void check_sample_rate(double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw Error("sample_rate", "the sample rate must be above 0 Hz", figure(sample_rate) + " Hz", "");
  }
}

void check_derivative(int derivative) {
  if (derivative < 0 || derivative > max_derivative) {
    throw Error("derivative", "must be a whole number in range", std::to_string(derivative),
                "use 0 to " + std::to_string(max_derivative));
  }
}

int whole_number(const FilterDesign& design, const std::string& key, int fallback, int least, int most) {
  const auto entry = design.numbers.find(key);
  if (entry == design.numbers.end()) return fallback;
  const double value = entry->second;
  if (!(value >= least && value <= most) || value != std::floor(value)) {
    throw Error(key, "must be a whole number in range", figure(value),
                "use " + std::to_string(least) + " to " + std::to_string(most));
  }
  return static_cast<int>(value);
}

double checked_cutoff(const FilterDesign& design) {
  const auto entry = design.numbers.find("cutoff");
  if (entry == design.numbers.end()) {
    throw Error("cutoff", "the filter needs a cut-off", "none", "add e.g. `cutoff: 50 Hz`");
  }
  const double cutoff = entry->second;
  if (!(cutoff > 0)) {
    throw Error("cutoff", "the cut-off must be above 0 Hz", figure(cutoff) + " Hz", "");
  }
  if (!(cutoff < design.sample_rate / 2)) {
    throw Error("cutoff", "the cut-off must lie below half the sample rate",
                figure(cutoff) + " Hz at " + figure(design.sample_rate) + " Hz",
                "use less than " + figure(design.sample_rate / 2) + " Hz, or sample faster");
  }
  return cutoff;
}

Parameter order_row(int fallback) {
  return key::integer("order", "order of the low-pass").otherwise(fallback).within(1, max_order);
}

Parameter ripple_row() {
  return key::number("ripple", "peak to peak below the cut-off, in dB").otherwise(1.0).above(0).up_to(60);
}

Parameter attenuation_row(std::string_view meaning) {
  return key::number("attenuation", meaning).otherwise(40.0).above(0).up_to(300);
}

Parameter cutoff_row(std::string_view meaning) {
  return key::number("cutoff", meaning, dimension::frequency).above(0).or_angular().needed();
}

double checked_number(const FilterDesign& design, const std::string& key, double above, double most,
                      std::optional<double> fallback) {
  const auto entry = design.numbers.find(key);
  if (entry == design.numbers.end()) {
    if (fallback) return *fallback;
    throw Error(key, "missing key", "", "add '" + key + ": ...'");
  }
  const double value = entry->second;
  if (!(value > above) || !(value <= most) || !std::isfinite(value)) {
    const bool bounded = std::isfinite(most);
    throw Error(key, "is out of range", figure(value),
                "above " + figure(above) + (bounded ? " and at most " + figure(most) : ""));
  }
  return value;
}

std::string checked_choice(const FilterDesign& design, const std::string& key,
                           const std::vector<std::string>& choices) {
  const auto entry = design.choices.find(key);
  if (entry == design.choices.end()) return choices.front();
  if (contains(choices, entry->second)) return entry->second;
  std::string known;
  for (const std::string& choice : choices) known += (known.empty() ? "" : ", ") + choice;
  throw Error(key, "is not one of the choices", "'" + escaped(entry->second) + "'", "use " + known);
}

std::size_t parameter_group(const FilterDesign& design, const std::vector<std::vector<std::string>>& groups) {
  const auto given = [&](const std::string& key) { return design.numbers.contains(key); };
  std::vector<std::string> all, found;
  std::string remedy;
  for (const auto& group : groups) {
    remedy += remedy.empty() ? "give " : ", or ";
    for (std::size_t i = 0; i < group.size(); ++i) {
      remedy += (i == 0 ? "" : i + 1 == group.size() ? " and " : ", ") + group[i];
      if (!contains(all, group[i])) all.push_back(group[i]);
    }
  }
  std::ranges::copy_if(all, std::back_inserter(found), given);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].size() == found.size() && std::ranges::all_of(groups[i], given)) return i;
  }
  std::string list;
  for (const std::string& key : found) list += (list.empty() ? "" : ", ") + key;
  throw Error(found.empty() ? groups[0][0] : found.back(), "these parameters do not define a filter",
              found.empty() ? "none" : list, remedy);
}

void check_derivative(const FilterDesign& design, int most, const std::string& rule) {
  if (design.derivative <= most) return;
  throw Error("derivative", rule, std::to_string(design.derivative), "use 0 to " + std::to_string(most));
}

Section section_of_pole(ComplexDoubleDouble p, DoubleDouble scale) {
  if (p.im == DoubleDouble(0)) return {{1, 0, 0}, {1, -scale / p.re, 0}};
  const DoubleDouble n = norm(p);
  return {{1, 0, 0}, {1, DoubleDouble(-2) * p.re / n * scale, scale * scale / n}};
}

DoubleDouble prewarped_slope(double cutoff, double rate) {
  const Real x = pi256() * cutoff / rate;
  return to_double_double(cos(x) / sin(x));
}

DoubleDouble attenuated(double decibels) { return to_double_double(exp(-log(Real(10)) * decibels / 20)); }

Real asinh(const Real& x) { return log(x + sqrt(x * x + 1)); }

Filter bilinear_lowpass(const FilterDesign& wanted, const Prototype& prototype) {
  Filter filter = difference_filter(wanted.sample_rate, wanted.derivative);
  filter.designed = true;
  const DoubleDouble slope = prewarped_slope(checked_cutoff(wanted), wanted.sample_rate);
  filter.gain *= prototype.gain;
  std::size_t zeros = 0;
  for (const ComplexDoubleDouble& p : prototype.poles) {
    Section section = section_of_pole(p, slope);
    if (section.a[2].hi != 0 && zeros < prototype.zeros.size()) {
      const DoubleDouble over = slope / prototype.zeros[zeros++];
      section.b[2] = over * over;
    }
    filter.sections.push_back(section);
  }
  return filter;
}

Parameter window_row() {
  return key::integer("window", "samples in the window").within(1, max_window).needed();
}
namespace {

using Real = Binary256;

/// The d-th derivatives at x of t_0 .. t_order, orthogonal on 0 .. n-1 (Abramowitz and Stegun 22.17):
/// (k+1) t_(k+1) = (2k+1)(2x - n + 1) t_k - k (n^2 - k^2) t_(k-1).
std::vector<Real> orthogonal(int order, int n, const Real& x, int d) {
  const auto size = static_cast<std::size_t>(order) + 1;
  std::vector<Real> lower(size), t(size);  // derivatives i - 1 and i
  for (int i = 0; i <= d; ++i) {
    t.assign(size, 0);
    if (i == 0) t[0] = 1;
    for (int k = 0; k < order; ++k) {
      const auto index = static_cast<std::size_t>(k);
      Real next = (2 * k + 1) * ((2 * x - (n - 1)) * t[index] + 2 * i * lower[index]);
      if (k > 0) next -= k * (Real(n) * n - k * k) * t[index - 1];
      t[index + 1] = next / (k + 1);
    }
    lower = t;
  }
  return t;
}

}  // namespace

Filter polynomial_fit(const FilterDesign& wanted, int window, int order, double back) {
  check_sample_rate(wanted.sample_rate);
  check_derivative(wanted.derivative);
  if (order >= window) {
    throw Error("polynomial_order", "the polynomial order must lie below the window",
                std::to_string(order) + " in a window of " + std::to_string(window),
                "use at most " + std::to_string(window - 1) + ", or a wider window");
  }
  if (order < wanted.derivative) {
    throw Error("polynomial_order", "the polynomial order must be at least the derivative",
                std::to_string(order) + " for derivative " + std::to_string(wanted.derivative),
                "use " + std::to_string(wanted.derivative) + " or more");
  }
  std::vector<Real> weights = orthogonal(order, window, Real(window - 1) - back, wanted.derivative);
  Real norm = window;  // sum t_k^2 = (n + k)!/((2k + 1)(n - k - 1)!)
  for (int k = 0; k <= order; ++k) {
    weights[k] /= norm;
    norm *= (Real(window) * window - Real(k + 1) * (k + 1)) * (2 * k + 1) / (2 * k + 3);
  }
  Filter filter{{}, 1, wanted.sample_rate, wanted.derivative};
  filter.designed = true;
  for (int i = 0; i < wanted.derivative; ++i) filter.gain *= wanted.sample_rate;
  for (int k = 0; k < window; ++k) {
    const std::vector<Real> t = orthogonal(order, window, window - 1 - k, 0);
    Real tap = 0;
    for (std::size_t j = 0; j < t.size(); ++j) tap += weights[j] * t[j];
    filter.taps.push_back(to_double_double(tap));
  }
  return filter;
}

namespace {

Section with_numerator(Section s, DoubleDouble b0, DoubleDouble b1, DoubleDouble b2) {
  s.b = {b0, b1, b2};
  return s;
}

}  // namespace

Parameter tracking_index_row() {
  return key::number("tracking_index",
                     "T^2 sigma_process/sigma_measurement, the process noise constant over each sample")
      .above(0);
}

Parameter position_gain_row() { return key::number("alpha", "gain of the position").above(0).up_to(2); }

Parameter velocity_gain_row() {
  return key::number("beta", "gain of the velocity; 2 alpha + beta < 4").above(0).up_to(4);
}

std::vector<DoubleDouble> spectral_factor(const std::vector<DoubleDouble>& p) {
  if (p.size() == 3) {
    const DoubleDouble c0 = sqrt(p[0]), c2 = sqrt(p[2]);
    return {c0, sqrt(p[1] + DoubleDouble(2) * c0 * c2), c2};
  }
  const DoubleDouble c0 = sqrt(p[0]), c3 = sqrt(p[3]);
  DoubleDouble c1, c2;
  // Each step divides the relative error by at least four: two square roots, each of which halves it.
  for (int i = 0; i < 80; ++i) {
    c1 = sqrt(p[1] + DoubleDouble(2) * c0 * c2);
    c2 = sqrt(p[2] + DoubleDouble(2) * c1 * c3);
  }
  return {c0, c1, c2, c3};
}

std::vector<DoubleDouble> piecewise_noise(int states, double index) {
  const DoubleDouble s = DoubleDouble(index) * DoubleDouble(index);
  // Process alone, |x/u|^2: (1 - w^2)/(16 w^4), (1 - w^2)^2/(64 (-w^2)^3).
  if (states == 2) return {s, s, 16};
  return {s, DoubleDouble(2) * s, s, 64};
}

std::vector<DoubleDouble> continuous_noise(int states, double ratio) {
  const DoubleDouble s = DoubleDouble(ratio) * DoubleDouble(ratio), one = 1;
  // The sampled integrators' numerators are Euler and Frobenius's z + 4 + 1/z over 6, and
  // z^2 + 26 z + 66 + 26/z + 1/z^2 over 120: (1 - w^2)(1 - w^2/3) and (1 - w^2)(1 - w^2 + (2/15) w^4).
  if (states == 2) return {s, DoubleDouble(4) / DoubleDouble(3) * s, DoubleDouble(16) + s / DoubleDouble(3)};
  return {s, DoubleDouble(2) * s, DoubleDouble(17) / DoubleDouble(15) * s,
          DoubleDouble(64) + DoubleDouble(2) / DoubleDouble(15) * s * one};
}

Filter tracking_filter(const FilterDesign& wanted, std::vector<DoubleDouble> c) {
  const int states = static_cast<int>(c.size()) - 1;
  check_derivative(wanted, states - 1,
                   states == 2 ? "two states estimate position and velocity"
                               : "three states estimate position, velocity and acceleration");
  Filter filter = difference_filter(wanted.sample_rate,
                                    wanted.derivative);  // throws for a wrong rate; its gain is (2f)^d
  filter.designed = true;
  filter.sections.clear();
  const DoubleDouble first = c[0], one = 1;
  for (DoubleDouble& x : c) x = x / first;
  if (states == 2) {
    const Section pair{{}, {1, c[1], c[2]}};
    filter.sections = {wanted.derivative == 0 ? with_numerator(pair, 1, c[1], c[1] - one)
                                              : with_numerator(pair, 0, 1, 1)};
    return filter;
  }
  std::vector<ComplexDoubleDouble> real, upper;
  for (const Complex1024& r :
       roots({to_binary1024(c[3]), to_binary1024(c[2]), to_binary1024(c[1]), to_binary1024(c[0])})) {
    if (r.im == 0) real.push_back(to_double_double(r.re));
    if (r.im > 0) upper.push_back({to_double_double(r.re), to_double_double(r.im)});
  }
  const Section single = section_of_pole(real.back(), 1);
  Section pair;
  if (upper.empty()) {
    const DoubleDouble u = one / real[0].re, v = one / real[1].re;
    pair.a = {1, -u - v, u * v};
  } else {
    pair = section_of_pole(upper[0], 1);
  }
  const DoubleDouble rise = c[1] - one;
  switch (wanted.derivative) {
    case 0:
      filter.sections = {with_numerator(single, 1, 1, 0), with_numerator(pair, 1, rise, c[2] - rise)};
      break;
    case 1:
      filter.sections = {with_numerator(single, 1, rise, 0), with_numerator(pair, 0, 1, 1)};
      break;
    default:
      filter.sections = {with_numerator(single, 0, 1, 0), with_numerator(pair, 0, 1, 1)};
  }
  return filter;
}

}  // namespace qerr
