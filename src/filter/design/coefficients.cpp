#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "filter/design/families/families.hpp"
#include "filter/design/polynomial.hpp"
#include "filter/norms/numerical_error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

constexpr std::size_t max_coefficients = 256;
constexpr double negligible_deviation = 1e-13;  // deviation relative to the H2 norm

/// u + v w; 1 - r z^-1 is ((1 - r) + (1 + r) w)/(1 + w).
struct Factor {
  Complex1024 u;
  Complex1024 v;
};

Factor factor_of_root(const Complex1024& r) { return {Complex1024(1.0) - r, Complex1024(1.0) + r}; }
const Factor delay{1.0, -1.0};  // z^-1 = (1 - w)/(1 + w)
const Factor unit{1.0, 1.0};    // (1 + w)/(1 + w)

using Polynomial = std::array<Binary1024, 3>;
using List = std::vector<double>;

void check_list(const std::vector<double>& list, const char* key) {
  if (list.empty()) throw Error(key, "needs at least one coefficient", "an empty list", "write e.g. [1]");
  for (const double c : list) {
    if (!std::isfinite(c)) throw Error(key, "the coefficients must be finite", figure(c), "");
  }
}

void trim(std::vector<double>& list) {
  while (list.size() > 1 && list.back() == 0) list.pop_back();
}

/// Bound of the shift of a root due to the rounding of the coefficients, to first order.
double root_uncertainty(const List& a, std::complex<double> root) {
  const double m = std::abs(root);
  double scale = 0;
  std::complex<double> value, slope;
  for (const double c : a) {
    slope = slope * root + value;
    value = value * root + c;
    scale = scale * m + std::abs(c);
  }
  const double moved = std::numeric_limits<double>::epsilon() * scale / std::max(std::abs(slope), 1e-300);
  // Multiple roots have no first-order bound; above this limit the coefficients are taken as exact.
  return std::min(moved, 1e-10);
}

Error unstable(double largest) {
  return Error("denominator", "the filter is not stable: a pole lies on or outside the unit circle",
               "largest pole modulus " + figure(largest),
               "all poles must lie inside; the coefficients ascend in z^-1");
}

struct FactoredPoles {
  std::vector<Complex1024> z;
  double largest = 0;  // modulus
};

FactoredPoles stable_poles(const List& a) {
  FactoredPoles poles{roots({a.begin(), a.end()})};
  bool stable = true;
  for (const Complex1024& r : poles.z) {
    const double modulus = static_cast<double>(magnitude(r));
    if (modulus >= 1 - root_uncertainty(a, {static_cast<double>(r.re), static_cast<double>(r.im)}))
      stable = false;
    poles.largest = std::max(poles.largest, modulus);
  }
  if (!stable) throw unstable(poles.largest);
  return poles;
}

/// The product of the factors as polynomials in w of order two, slow ones first: conjugate pairs, then real
/// ones in pairs; a last one of order one if their number is odd.
std::vector<Polynomial> polynomials(const std::vector<Factor>& factors) {
  std::vector<std::array<Factor, 2>> pairs;
  std::vector<Factor> real;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (factors[i].u.im == 0) {
      real.push_back(factors[i]);
    } else {
      pairs.push_back({factors[i], factors[i + 1]});
      ++i;
    }
  }
  const auto slower = [](const Factor& x, const Factor& y) { return magnitude(x.u) < magnitude(y.u); };
  std::ranges::stable_sort(real, slower);
  for (std::size_t i = 0; i + 1 < real.size(); i += 2) pairs.push_back({real[i], real[i + 1]});
  std::ranges::stable_sort(pairs, [&](const auto& x, const auto& y) { return slower(x[0], y[0]); });
  std::vector<Polynomial> result;
  for (const auto& [x, y] : pairs) {
    result.push_back({(x.u * y.u).re, (x.u * y.v + x.v * y.u).re, (x.v * y.v).re});
  }
  if (real.size() % 2 == 1) result.push_back({real.back().u.re, real.back().v.re, Binary1024(0)});
  return result;
}

/// Divides by the lowest coefficient that is not 0: the gain is in Filter::gain alone.
std::array<DoubleDouble, 3> scaled(const Polynomial& p) {
  const auto lowest = std::ranges::find_if(p, [](const Binary1024& c) { return c != 0; });
  std::array<DoubleDouble, 3> result;
  for (std::size_t i = 0; i < 3; ++i) result[i] = to_double_double(p[i] / *lowest);
  return result;
}

/// The sections of b/a, from the zeros at z = 1 and the roots of the deflated numerator.
Filter factored(Filter filter, Deflated<Binary1024> zeros, const List& a, const FactoredPoles& poles) {
  std::vector<Factor> below, above;
  for (const Complex1024& r : poles.z) below.push_back(factor_of_root(r));
  const Binary1024 slope = sum(zeros.quotient);
  filter.gain =
      to_double_double(ldexp(slope / sum(std::vector<Binary1024>(a.begin(), a.end())), zeros.zeros));
  for (int i = 0; i < zeros.zeros; ++i) above.push_back({0.0, 2.0});
  while (zeros.quotient.front() == 0) {
    zeros.quotient.erase(zeros.quotient.begin());
    above.push_back(delay);
  }
  for (const Complex1024& r : roots(zeros.quotient)) above.push_back(factor_of_root(r));
  while (above.size() < below.size()) above.push_back(unit);
  while (below.size() < above.size()) below.push_back(unit);
  const std::vector<Polynomial> upper = polynomials(above), lower = polynomials(below);
  for (std::size_t i = 0; i < lower.size(); ++i)
    filter.sections.push_back({scaled(upper[i]), scaled(lower[i])});
  return filter;
}

}  // namespace

Filter filter_from_coefficients(const List& numerator, const List& denominator, double sample_rate,
                                int derivative) {
  check_sample_rate(sample_rate);
  check_derivative(derivative);
  check_list(numerator, "numerator");
  check_list(denominator, "denominator");
  if (denominator[0] == 0) {
    throw Error("denominator", "the first coefficient a0 must not be 0", "0", "leave out leading zeros");
  }
  List b = numerator, a = denominator;
  trim(a);
  trim(b);
  Filter filter{{}, 1, sample_rate, derivative};
  if (a.size() == 1 || (b.size() == 1 && b[0] == 0)) {
    if (a.size() > 1) stable_poles(a);
    // The largest tap between 1 and 2: the squares of all stay in the range of double.
    double largest = 0;
    for (const double c : b) largest = std::max(largest, std::abs(c));
    const int exponent = largest > 0 ? std::ilogb(largest) : 0;
    for (const double c : b) filter.taps.push_back(std::ldexp(c, -exponent));
    filter.gain = to_double_double(ldexp(Binary1024(1) / Binary1024(a[0]), exponent));
    for (const double c : b) filter.deviation.l1 += RoundingErrors<DoubleDouble>::unit * std::abs(c / a[0]);
    filter.deviation.h2 = filter.deviation.l1;
    return filter;
  }
  if (std::max(a.size(), b.size()) > max_coefficients) {
    throw Error(a.size() > b.size() ? "denominator" : "numerator",
                "too many coefficients for a filter with poles", std::to_string(std::max(a.size(), b.size())),
                "use at most " + std::to_string(max_coefficients));
  }
  const FactoredPoles poles = stable_poles(a);
  Filter result;
  std::optional<Deviation> deviation;
  // A filter that blocks 0 Hz up to the rounding of its coefficients is taken to block it, unless a slow pole
  // amplifies that rounding.
  for (const double rounding : {0.5 * std::numeric_limits<double>::epsilon(), 0.0}) {
    result = factored(filter, divide_out_dc_zeros<Binary1024>(b, rounding), a, poles);
    deviation = deviation_of(result, b, a, poles.largest);
    if (!deviation) throw unstable(poles.largest);
    if (deviation->h2 <= negligible_deviation * h2_norm(result)) break;
  }
  result.deviation = *deviation;
  return result;
}

}  // namespace qerr
