#include "filter/norms/deviation.hpp"

#include <cmath>

#include "filter/norms/rational.hpp"

namespace qerr {
namespace {

/// The number with at least as many bits, exactly: the sum of its leading doubles.
template <class T>
T widened(const Binary1024& x) {
  int exponent = 0;
  Binary1024 remaining = frexp(x, &exponent);
  T sum = 0;
  while (remaining != 0) {
    const double part = static_cast<double>(remaining);
    sum += part;
    remaining -= part;
  }
  return ldexp(sum, exponent);
}

/// (1 + w)^n c(q), q (1 + w) = (1 + lift) (1 - w), ascending in w.
template <class T>
std::vector<Ball<T>> in_w(const std::vector<Binary1024>& c, std::size_t n, double lift) {
  const std::vector<Ball<T>> plus{1.0, 1.0}, minus{1.0, -1.0};
  const Ball<T> up = Ball<T>(1.0) + Ball<T>(lift);
  std::vector<Ball<T>> p{c.size() > n ? Ball<T>(widened<T>(c[n])) : Ball<T>()}, power{1.0};
  for (std::size_t k = n; k-- > 0;) {
    p = product(p, minus);
    power = product(power, plus);
    for (std::size_t i = 0; i < p.size(); ++i) {
      p[i] *= up;
      if (k < c.size()) p[i] += Ball<T>(widened<T>(c[k])) * power[i];
    }
  }
  return p;
}

/// An upper bound of ||b/a - H||_2, both with z/(1 + lift) for z.
template <class T>
std::optional<double> difference(const Filter& h, const std::vector<Binary1024>& b,
                                 const std::vector<Binary1024>& a, double lift) {
  const std::size_t n = std::max(a.size(), b.size()) - 1;
  Rational<T> factored = rational<T>(h, lift);
  for (Ball<T>& c : factored.b) c *= Ball<T>::exactly(h.gain);
  const std::vector<Ball<T>> specified = in_w<T>(a, n, lift);
  std::vector<Ball<T>> numerator = product(in_w<T>(b, n, lift), factored.a);
  const std::vector<Ball<T>> subtrahend = product(factored.b, specified);
  for (std::size_t i = 0; i < numerator.size(); ++i) numerator[i] -= subtrahend[i];
  const auto squared = squared_norm(Rational<T>{numerator, product(specified, factored.a)});
  if (!squared) return std::nullopt;
  return static_cast<double>(sqrt(*squared).largest()) * (1 + 0x1p-50);
}

std::optional<double> difference(const Filter& h, const std::vector<Binary1024>& b,
                                 const std::vector<Binary1024>& a, double lift) {
  if (const auto d = difference<Binary1024>(h, b, a, lift)) return d;
  return difference<Binary<4096>>(h, b, a, lift);
}

}  // namespace

std::optional<Deviation> deviation_of(const Filter& h, const std::vector<double>& b,
                                      const std::vector<double>& a, double modulus) {
  return deviation_of(h, std::vector<Binary1024>(b.begin(), b.end()),
                      std::vector<Binary1024>(a.begin(), a.end()), modulus);
}

std::optional<Deviation> deviation_of(const Filter& h, const std::vector<Binary1024>& b,
                                      const std::vector<Binary1024>& a, double modulus) {
  const auto plain = difference(h, b, a, 0);
  if (!plain) return std::nullopt;
  // Cauchy and Schwarz: sum |d_k| <= (sum r^2k)^(1/2) (sum (d_k r^-k)^2)^(1/2), r = 1/(1 + lift).
  const double lift = std::min(1.0, 0.5 * (1 - modulus) / modulus);
  const auto lifted = difference(h, b, a, lift);
  const double sum = (1 + lift) / std::sqrt(lift * (2 + lift));
  return Deviation{*plain, lifted ? *lifted * sum * (1 + 0x1p-40) : std::numeric_limits<double>::infinity()};
}

}  // namespace qerr
