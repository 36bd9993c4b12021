#include "filter/corners.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/design/polynomial.hpp"

namespace qerr {
namespace {

using Root = std::complex<double>;

/// Both roots in w of a polynomial of a section; fewer where its order is lower.
std::vector<Root> roots_in_w(const std::array<DoubleDouble, 3>& c) {
  const double c0 = c[0].hi, c1 = c[1].hi, c2 = c[2].hi;
  if (c2 == 0) return c1 == 0 ? std::vector<Root>{} : std::vector<Root>{-c0 / c1};
  const Root discriminant = std::sqrt(Root(static_cast<double>(c[1] * c[1] - DoubleDouble(4) * c[0] * c[2])));
  // The larger root by the formula without cancellation, the smaller one from the product.
  const Root large = -0.5 * (c1 < 0 ? c1 - discriminant : c1 + discriminant);
  if (large == 0.0) return {0.0, 0.0};
  return {c0 / large, large / c2};
}

/// Zeros slower than this, relative to the slowest pole, are due to the rounding of coefficients: taken to be
/// at 0 Hz. Between them and the slowest pole the filter estimates its derivative over twelve decades.
constexpr double at_dc = 1e-12;

}  // namespace

Corners corners(const Filter& filter) {
  Corners c;
  for (const Section& s : filter.sections) {
    for (const Root& w : roots_in_w(s.b)) c.zeros.push_back(w);
    for (const Root& w : roots_in_w(s.a)) c.poles.push_back(w);
  }
  for (const Root& w : c.poles) c.slowest_pole = std::min(c.slowest_pole, std::abs(w));
  return c;
}

double limit_at_dc(const Filter& filter) {
  const double slowest = at_dc * corners(filter).slowest_pole;
  DoubleDouble limit = filter.gain;
  int zeros = 0;
  for (const Section& s : filter.sections) {
    std::size_t lead = 0;
    for (const Root& w : roots_in_w(s.b)) lead += std::abs(w) <= slowest ? 1 : 0;
    if (s.b[lead] == 0) return 0;
    zeros += static_cast<int>(lead);
    limit *= s.b[lead] / s.a[0];
    if (static_cast<int>(lead) > 0) limit *= DoubleDouble(std::ldexp(1.0, -static_cast<int>(lead)));
  }
  if (!filter.taps.empty()) {
    const Deflated<DoubleDouble> d = divide_out_dc_zeros<DoubleDouble>(filter.taps);
    limit *= sum(d.quotient);
    zeros += d.zeros;
  }
  if (limit == 0 || zeros > filter.derivative) return 0;
  if (zeros < filter.derivative) return std::copysign(std::numeric_limits<double>::infinity(), limit.hi);
  for (int i = 0; i < zeros; ++i) limit = limit / DoubleDouble(filter.sample_rate);
  return static_cast<double>(limit);
}

}  // namespace qerr
