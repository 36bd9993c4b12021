#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <vector>

/// An independent ||b/a||_2 for tests: 1200 digits, in z^-1, by the step-down recursion of Levinson and
/// Durbin.
namespace qerr::reference {

using Exact =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<1200>, boost::multiprecision::et_off>;
using Exacts = std::vector<Exact>;

inline Exacts product(const Exacts& p, const Exacts& q) {
  Exacts r(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = 0; j < q.size(); ++j) r[i + j] += p[i] * q[j];
  return r;
}

/// Step down: with k_n = a_n, a^(n-1)_i = (a_i - k_n a_(n-i))/(1 - k_n^2). The backward polynomials are an
/// orthogonal basis of B/A: sum c_n^2/prod_{i>n}(1 - k_i^2) is the norm squared, c_n the coefficient of b
/// along them. Negative when a pole is not inside the circle.
inline Exact squared_norm(Exacts b, Exacts a) {
  const std::size_t order = std::max(a.size(), b.size()) - 1;
  a.resize(order + 1);
  b.resize(order + 1);
  for (std::size_t i = order + 1; i-- > 0;) {
    b[i] /= a[0];
    a[i] /= a[0];
  }
  Exact total = 0, weight = 1;
  for (std::size_t n = order;; --n) {
    // The last coefficient of b goes to the backward polynomial q^n a(1/q), whose last coefficient is 1.
    const Exact c = b[n];
    total += c * c * weight;
    if (n == 0) return total;
    for (std::size_t i = 0; i < n; ++i) b[i] -= c * a[n - i];
    const Exact k = a[n];
    if (!(abs(k) < 1)) return -1;
    Exacts lower(n);
    for (std::size_t i = 0; i < n; ++i) lower[i] = (a[i] - k * a[n - i]) / (1 - k * k);
    a = lower;
    weight /= 1 - k * k;
    b.resize(n);
  }
}

}  // namespace qerr::reference
