#include "filter/design/ratio.hpp"

#include <algorithm>

#include "filter/norms/rational.hpp"

namespace qerr {
namespace {

constexpr double negligible_coefficient =
    1e-290;  // above the rounding of 1024 bits (1e-308), below any meant ratio

PolynomialInW section_polynomial(const std::array<DoubleDouble, 3>& c, std::size_t order) {
  PolynomialInW p;
  for (std::size_t i = 0; i <= order; ++i) p.push_back(to_binary1024(c[i]));
  return p;
}

bool vanishes(const PolynomialInW& p) {
  return std::ranges::all_of(p, [](const Binary1024& c) { return c == 0; });
}

}  // namespace

PolynomialInW in_w(const std::vector<Binary1024>& p) {
  // z^-1 = (1 - w)/(1 + w). Horner from the last: sum <- sum (1 - w) + p_k (1 + w)^(n - k).
  PolynomialInW sum{p.back()}, power{1};
  const auto times_linear = [](const PolynomialInW& x, int sign) {
    PolynomialInW r(x.size() + 1);
    for (std::size_t i = 0; i < x.size(); ++i) {
      r[i] += x[i];
      r[i + 1] += sign * x[i];
    }
    return r;
  };
  for (std::size_t k = p.size() - 1; k-- > 0;) {
    sum = times_linear(sum, -1);
    power = times_linear(power, 1);
    for (std::size_t i = 0; i < power.size(); ++i) sum[i] += p[k] * power[i];
  }
  return sum;
}

TransferRatio ratio_of_delays(std::vector<Binary1024> b, std::vector<Binary1024> a) {
  const std::size_t size = std::max(a.size(), b.size());
  a.resize(size);
  b.resize(size);
  return {in_w(b), in_w(a)};
}

TransferRatio ratio_of(const Filter& f) {
  if (!f.taps.empty()) {
    std::vector<Binary1024> taps;
    for (const DoubleDouble& h : f.taps) taps.push_back(to_binary1024(h) * to_binary1024(f.gain));
    return ratio_of_delays(taps, {1});
  }
  TransferRatio r{{to_binary1024(f.gain)}, {1}};
  for (const Section& s : f.sections) {
    const std::size_t order = order_of(s);
    r.b = times(r.b, section_polynomial(s.b, order));
    r.a = times(r.a, section_polynomial(s.a, order));
  }
  return r;
}

PolynomialInW sum(const PolynomialInW& x, const PolynomialInW& y) {
  PolynomialInW s = x.size() < y.size() ? y : x;
  const PolynomialInW& shorter = x.size() < y.size() ? x : y;
  for (std::size_t i = 0; i < shorter.size(); ++i) s[i] += shorter[i];
  return s;
}

void remove_rounding(PolynomialInW& p) {
  Binary1024 largest = 0;
  for (const Binary1024& c : p) largest = std::max(largest, Binary1024(abs(c)));
  for (Binary1024& c : p) {
    if (abs(c) <= largest * negligible_coefficient) c = 0;
  }
}

Factored factored(PolynomialInW p) {
  remove_rounding(p);
  while (p.back() == 0) p.pop_back();
  const auto start = std::ranges::find_if(p, [](const Binary1024& c) { return c != 0; });
  Factored f{*start, std::vector<LinearFactor>(start - p.begin(), {0.0, 1.0}), {}};
  std::ranges::reverse(p);
  while (p.back() == 0) p.pop_back();
  f.roots = roots(p);
  for (std::size_t i = 0; i < f.roots.size(); ++i) {
    Complex1024& r = f.roots[i];
    for (std::size_t j = 0; j < i; ++j) {
      if (magnitude(r - f.roots[j]) < 1e-28L * magnitude(r)) r = f.roots[j];
    }
    if (abs(r.im) < abs(r.re) * 1e-30) r.im = 0;
    if (r.im >= 0) f.factors.push_back({1.0, Complex1024(-1.0) / r});
  }
  return f;
}

double largest_modulus(const std::vector<Complex1024>& roots_in_w, double uncertainty, bool& stable) {
  Binary1024 largest = 0;
  stable = true;
  for (const Complex1024& w : roots_in_w) {
    const Complex1024 up{1 + w.re, w.im}, down{1 - w.re, -w.im};
    // 1 - |z|^2 = -4 Re w/|1 - w|^2
    if (!(-4 * w.re > 2 * uncertainty * norm(down))) stable = false;
    largest = std::max(largest, Binary1024(sqrt(Binary1024(norm(up) / norm(down)))));
  }
  return static_cast<double>(largest);
}

void cancel_at_dc(TransferRatio& r) {
  remove_rounding(r.b);
  remove_rounding(r.a);
  while (r.a.size() > 1 && r.a.front() == 0 && r.b.front() == 0 && !vanishes(r.b)) {
    r.a.erase(r.a.begin());
    r.b.erase(r.b.begin());
  }
}

bool is_stable(TransferRatio r, double uncertainty) {
  cancel_at_dc(r);
  if (r.a.front() == 0 || r.a.back() == 0) return false;
  bool stable = false;
  largest_modulus(factored(r.a).roots, uncertainty, stable);
  return stable;
}

Filter filter_of(TransferRatio r, double sample_rate, const std::vector<LinearFactor>& more,
                 const Factored* poles) {
  if (!poles) cancel_at_dc(r);
  if (vanishes(r.b)) return {{}, 0, sample_rate, 0, {1}};
  Factored above = factored(r.b);
  const Factored below = poles ? *poles : factored(r.a);
  above.factors.insert(above.factors.end(), more.begin(), more.end());
  Filter filter = filter_from_factors(above.lead / below.lead, above.factors, below.factors, sample_rate, 0);
  filter.designed = true;  // the rounding of the factors is below the allowance for that of a design
  return filter;
}

Factored poles_of(const Filter& f) {
  Factored all{1, {}, {}};
  for (const Section& s : f.sections) {
    const std::size_t order = order_of(s);
    const PolynomialInW a = section_polynomial(s.a, order);
    const Binary1024 discriminant = order == 2 ? a[1] * a[1] - 4 * a[0] * a[2] : Binary1024(0);
    if (order < 2) {
      all.factors.push_back({a[0], order == 1 ? a[1] : Binary1024(0)});
    } else if (discriminant < 0) {  // a0 |1 - w/r|^2, 1/r = (-a1 -+ i sqrt(-D))/(2 a0)
      all.lead *= a[0];
      all.factors.push_back({1.0, {a[1] / (2 * a[0]), sqrt(-discriminant) / (2 * a[0])}});
    } else {
      // a0 + a1 w + a2 w^2 = (a0 + s w)(1 + a2 w/s), s the larger of (a1 +- sqrt(D))/2
      const Binary1024 root = sqrt(discriminant), larger = 0.5 * (a[1] < 0 ? a[1] - root : a[1] + root);
      all.factors.push_back({a[0], larger});
      all.factors.push_back({1.0, a[2] / larger});
    }
  }
  return all;
}

}  // namespace qerr
