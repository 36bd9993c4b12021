#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// b(w)/a(w), ascending coefficients in ball arithmetic.
template <class T>
struct Rational {
  std::vector<Ball<T>> b;
  std::vector<Ball<T>> a;
};

template <class T>
std::vector<Ball<T>> product(const std::vector<Ball<T>>& p, const std::vector<Ball<T>>& q) {
  std::vector<Ball<T>> r(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < q.size(); ++j) r[i + j] += p[i] * q[j];
  }
  return r;
}

inline std::size_t order_of(const Section& s) { return !(s.a[2] == 0) ? 2 : !(s.a[1] == 0) ? 1 : 0; }

/// The polynomial of a section with z replaced by z/(1 + lift), up to a power of 1 + w that numerator and
/// denominator have in common. The impulse response becomes h_k (1 + lift)^k.
///
/// With q = z^-1, c(w) (1 + q)^2 is a polynomial in q. Substituting q (1 + lift) and returning to w gives 4 c
/// plus terms in lift, so that slow poles keep their digits.
template <class T>
std::vector<Ball<T>> lifted(const std::array<DoubleDouble, 3>& c, std::size_t order, double lift) {
  const Ball<T> c0 = Ball<T>::exactly(c[0]), c1 = Ball<T>::exactly(c[1]), c2 = Ball<T>::exactly(c[2]);
  if (lift == 0 || order == 0) {
    std::vector<Ball<T>> all{c0, c1, c2};
    all.resize(order + 1);
    return all;
  }
  const Ball<T> e(lift), two(2.0), four(4.0);
  if (order == 1) {
    const Ball<T> half = e * (c0 - c1);
    return {two * c0 + half, two * c1 - half};
  }
  const Ball<T> square = e * e * (c0 - c1 + c2);
  return {four * c0 + e * (four * c0 - two * c1) + square,
          four * c1 - two * (two * e * (c0 - c1 + c2) + square),
          four * c2 + e * (four * c2 - two * c1) + square};
}

/// The filter without its gain as a ratio of polynomials in w; its impulse response is h_k (1 + lift)^k/gain.
/// @pre no taps
template <class T>
Rational<T> rational(const Filter& filter, double lift = 0) {
  Rational<T> r{{Ball<T>(1.0)}, {Ball<T>(1.0)}};
  for (const Section& s : filter.sections) {
    const std::size_t order = order_of(s);
    r.b = product(r.b, lifted<T>(s.b, order, lift));
    r.a = product(r.a, lifted<T>(s.a, order, lift));
  }
  return r;
}

/// w = 2^shift v, exactly: the powers of a slow pole neither overflow nor underflow.
template <class T>
void scale_variable(std::vector<Ball<T>>& p, int shift) {
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = p[i].scaled(shift * static_cast<int>(i));
}

/// (1/2 pi) int |b(j Omega)/a(j Omega)|^2 dOmega by Astrom's recursion; empty unless a is proven stable
/// (every alpha > 0).
///
/// For a stable a the alphas and the terms are positive, so that their sum does not cancel; the rows of the
/// table do for small damping.
/// @pre degree of b < degree of a
template <class T>
std::optional<Ball<T>> integral(std::vector<Ball<T>> a, std::vector<Ball<T>> b) {
  std::ranges::reverse(a);
  b.resize(a.size() - 1);
  std::ranges::reverse(b);
  Ball<T> total;
  for (std::size_t n = a.size() - 1; n > 0; --n) {
    const Ball<T> alpha = a[0] / a[1], beta = b[0] / a[1];
    if (!alpha.above_zero()) return std::nullopt;
    total += beta * beta / (Ball<T>(2.0) * alpha);
    for (std::size_t i = 0; i < n; ++i) {
      if (i + 1 < n) {
        b[i] = b[i + 1];
        if (i % 2 == 1) b[i] -= beta * a[i + 2];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      a[i] = a[i + 1];
      if (i % 2 == 1 && i + 2 <= n) a[i] -= alpha * a[i + 2];
    }
  }
  return total;
}

/// ||b/a||_2^2 on the unit circle |z| = 1; empty unless a is proven stable.
template <class T>
std::optional<Ball<T>> squared_norm(Rational<T> r) {
  // d theta = 2 dOmega/(1 + Omega^2): the measure of the unit circle adds 1 + w to the denominator.
  r.a = product(r.a, {Ball<T>(1.0), Ball<T>(1.0)});
  const double ratio =
      static_cast<double>(std::log2(r.a.front().largest()) - std::log2(r.a.back().largest()));
  if (!std::isfinite(ratio)) return std::nullopt;
  const int shift = static_cast<int>(std::lround(ratio / static_cast<double>(r.a.size() - 1)));
  scale_variable(r.a, shift);
  scale_variable(r.b, shift);
  const auto value = integral(std::move(r.a), std::move(r.b));
  if (!value) return std::nullopt;
  return value->scaled(shift + 1);
}

}  // namespace qerr
