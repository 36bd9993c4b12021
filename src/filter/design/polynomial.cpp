#include "filter/design/polynomial.hpp"

#include <algorithm>
#include <complex>
#include <limits>
#include <numbers>

namespace qerr {

namespace {

using Quick = std::complex<double>;

template <class Number>
struct Evaluation {
  Number value{};
  Number slope{};
};

template <class Number, class Coefficient>
Evaluation<Number> evaluate(const std::vector<Coefficient>& descending, const Number& z) {
  Evaluation<Number> e;
  for (const Coefficient& c : descending) {
    e.slope = e.slope * z + e.value;
    e.value = e.value * z + Number(c);
  }
  return e;
}

/// sum |c_k| |z|^(n-k): the rounding error of a value is relative to it.
template <class Coefficient>
long double scale(const std::vector<Coefficient>& descending, long double modulus) {
  long double s = 0;
  for (const Coefficient& c : descending) s = s * modulus + std::abs(static_cast<long double>(c));
  return s;
}

long double magnitude(const Quick& z) { return std::abs(z); }
Quick quick(const Quick& z) { return z; }
Quick quick(const Complex1024& z) { return {static_cast<double>(z.re), static_cast<double>(z.im)}; }

/// One Gauss-Seidel sweep. Aberth's correction for the other roots is needed in double precision only.
/// @returns the largest relative step
template <class Number, class Coefficient>
long double sweep(const std::vector<Coefficient>& descending, std::vector<Number>& z, long double rounding) {
  long double largest = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const auto e = evaluate(descending, z[i]);
    const long double modulus = magnitude(z[i]);
    if (magnitude(e.value) <= rounding * scale(descending, modulus) || magnitude(e.slope) == 0) continue;
    const Number newton = e.value / e.slope;
    Quick others = 0;
    for (std::size_t j = 0; j < z.size(); ++j) {
      const Number gap = z[i] - z[j];
      // Relative to Newton's step: for close roots both can be below the range of double.
      if (j != i && magnitude(gap) > 0) others += quick(newton / gap);
    }
    const Quick damping = 1.0 - others;
    const Number step = std::abs(damping) > 0 ? newton / Number(damping.real(), damping.imag()) : newton;
    z[i] = z[i] - step;
    largest = std::max(largest, magnitude(step) / std::max(modulus, std::numeric_limits<long double>::min()));
  }
  return largest;
}

std::vector<Quick> first_guess(const std::vector<Binary1024>& descending) {
  const std::size_t n = descending.size() - 1;
  const auto size = [](const Binary1024& c) { return std::log(std::abs(static_cast<long double>(c))); };
  const double radius =
      static_cast<double>(std::exp((size(descending[n]) - size(descending[0])) / static_cast<double>(n)));
  std::vector<Quick> z(n);
  for (std::size_t k = 0; k < n; ++k) {
    // The offset 0.4 rad keeps the guesses off the symmetry axes of the polynomial.
    z[k] = std::polar(radius, 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n) + 0.4);
  }
  std::vector<double> c;
  for (const Binary1024& x : descending) c.push_back(static_cast<double>(x / descending[0]));
  std::vector<Quick> settled = z;
  for (int i = 0; i < 60; ++i) {
    if (sweep(c, settled, 1e-15L) < 1e-14L) break;
  }
  const bool finite = std::ranges::all_of(
      settled, [](Quick x) { return std::isfinite(x.real()) && std::isfinite(x.imag()); });
  return finite ? settled : z;
}

/// Makes conjugates exact. A root is real if it is itself the root nearest to its conjugate.
std::vector<Complex1024> paired(std::vector<Complex1024> z) {
  std::vector<Complex1024> result;
  while (!z.empty()) {
    const auto top = std::ranges::max_element(
        z, [](const Complex1024& a, const Complex1024& b) { return abs(a.im) < abs(b.im); });
    const Complex1024 root = *top;
    auto partner = top;
    long double nearest = std::numeric_limits<long double>::infinity();
    for (auto it = z.begin(); it != z.end(); ++it) {
      const long double distance = magnitude(*it - conj(root));
      if (distance < nearest) {
        nearest = distance;
        partner = it;
      }
    }
    if (partner == top) {
      result.emplace_back(root.re);
      z.erase(top);
      continue;
    }
    const Complex1024 mean{(root.re + partner->re) / 2, abs(root.im - partner->im) / 2};
    result.push_back(mean);
    result.push_back(conj(mean));
    z.erase(std::max(top, partner));
    z.erase(std::min(top, partner));
  }
  return result;
}

}  // namespace

long double magnitude(const Complex1024& x) {
  return std::hypot(static_cast<long double>(x.re), static_cast<long double>(x.im));
}

std::vector<Complex1024> roots(const std::vector<Binary1024>& descending) {
  if (descending.size() < 2) return {};
  const std::size_t n = descending.size() - 1;
  std::vector<Complex1024> z;
  for (const Quick& guess : first_guess(descending))
    z.emplace_back(Binary1024(guess.real()), Binary1024(guess.imag()));
  // Multiple roots converge linearly; the number of sweeps is limited to bound the time of long polynomials.
  const std::size_t sweeps = std::clamp<std::size_t>(800'000 / (n * n), 12, 400);
  for (std::size_t i = 0; i < sweeps; ++i) {
    if (sweep(descending, z, std::ldexp(1.0L, -1015)) < std::ldexp(1.0L, -900)) break;
  }
  return paired(std::move(z));
}

}  // namespace qerr
