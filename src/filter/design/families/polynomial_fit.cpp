#include "filter/design/families/polynomial_fit.hpp"

#include "filter/norms/ball.hpp"

namespace qerr {

Parameter window_row() {
  return {.name = "window",
          .kind = Kind::integer,
          .meaning = "samples in the window",
          .required = true,
          .least = 1,
          .most = max_window};
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
    throw Error(Fault{{},
                      "polynomial_order",
                      "the polynomial order must lie below the window",
                      std::to_string(order) + " in a window of " + std::to_string(window),
                      "use at most " + std::to_string(window - 1) + ", or a wider window"});
  }
  if (order < wanted.derivative) {
    throw Error(Fault{{},
                      "polynomial_order",
                      "the polynomial order must be at least the derivative",
                      std::to_string(order) + " for derivative " + std::to_string(wanted.derivative),
                      "use " + std::to_string(wanted.derivative) + " or more"});
  }
  std::vector<Real> weights = orthogonal(order, window, Real(window - 1) - back, wanted.derivative);
  Real norm = window;  // sum t_k^2 = (n + k)!/((2k + 1)(n - k - 1)!)
  for (int k = 0; k <= order; ++k) {
    weights[static_cast<std::size_t>(k)] /= norm;
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

}  // namespace qerr
