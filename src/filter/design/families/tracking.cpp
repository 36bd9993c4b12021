#include "filter/design/families/tracking.hpp"

#include <cmath>
#include <limits>

#include "filter/design/families/prototype.hpp"
#include "filter/design/polynomial.hpp"

namespace qerr {
namespace {

/// s with another numerator.
Section with_numerator(Section s, DoubleDouble b0, DoubleDouble b1, DoubleDouble b2) {
  s.b = {b0, b1, b2};
  return s;
}

}  // namespace

Parameter tracking_index_row() {
  return {.name = "tracking_index",
          .kind = Kind::number,
          .meaning = "T^2 sigma_process/sigma_measurement, the process noise constant over each sample",
          .least = 0,
          .open_below = true};
}

Parameter position_gain_row() {
  return {.name = "alpha",
          .kind = Kind::number,
          .meaning = "gain of the position",
          .least = 0,
          .most = 2,
          .open_below = true};
}

Parameter velocity_gain_row() {
  return {.name = "beta",
          .kind = Kind::number,
          .meaning = "gain of the velocity; 2 alpha + beta < 4",
          .least = 0,
          .most = 4,
          .open_below = true};
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
