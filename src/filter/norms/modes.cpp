#include "filter/norms/modes.hpp"

#include <algorithm>

#include "filter/norms/rational.hpp"

namespace qerr {
namespace {

using Series = std::vector<ComplexBall>;  // power series in eta, truncated

// Poles closer than this, relative to their distance from the unit circle, are one multiple pole.
constexpr double merge_distance = 4e-15;

/// Adds a pole, or merges it into one of the list. @returns the pole in the list
ComplexDoubleDouble add_pole(std::vector<Pole>& list, const ComplexDoubleDouble& w) {
  const double limit = merge_distance * std::abs(w.re.hi);
  const auto near = std::ranges::find_if(list, [&](const Pole& p) {
    return p.real() == (w.im == DoubleDouble(0)) && magnitude(p.w - w) <= limit;
  });
  if (near == list.end()) {
    list.push_back({w, 1});
    return w;
  }
  ++near->multiplicity;
  return near->w;
}

/// ||1/(w - p)||_1 = ||(1 + q)/((1 - p)(1 - z q))||_1 <= 2/(|1 - p| (1 - |z|)) <= |1 - p|/(-Re p), for
/// 1 - |z| >= (1 - |z|^2)/2 = -2 Re p/|1 - p|^2.
double reciprocal_norm(const ComplexDoubleDouble& p) {
  return magnitude(ComplexDoubleDouble(1.0) - p) / -p.re.hi * (1 + 0x1p-40);
}

/// sum over the coefficients d_k of a(w) - a2 (w - p)(w - r), each times ||w^k/a||_1: the relative change, in
/// l1, of a filter when the section's poles are replaced by p and r.
double relative_change(const Section& s, const ComplexDoubleDouble& p, const ComplexDoubleDouble& r) {
  const ComplexBall sum = exact_ball(p) + exact_ball(r), product = exact_ball(p) * exact_ball(r);
  const RealBall a2(s.a[2]);
  const double d0 = (RealBall(s.a[0]) - a2 * product.re).largest(),
               d1 = (RealBall(s.a[1]) + a2 * sum.re).largest();
  const double gp = reciprocal_norm(p), gr = reciprocal_norm(r);
  double n0 = gp * gr, n1 = (1 + magnitude(p) * gp) * gr;
  const double gap = magnitude(p - r);
  if (gap > 0) {
    // 1/((w - p)(w - r)) = [1/(w - p) - 1/(w - r)]/(p - r), and w/((w - p)(w - r)) with p and r as
    // numerators: much smaller than the product for a slow pair, and for a slow pole beside a fast one.
    n0 = std::min(n0, (gp + gr) / gap);
    n1 = std::min(n1, (magnitude(p) * gp + magnitude(r) * gr) / gap);
  }
  return (d0 * n0 + d1 * n1) / std::abs(s.a[2].hi) * (1 + 0x1p-40);
}

/// Adds the poles of a section. @returns the relative change in l1 of the filter
double add_section(std::vector<Pole>& list, const Section& s) {
  const DoubleDouble a0 = s.a[0], a1 = s.a[1], a2 = s.a[2];
  if (order_of(s) == 0) return 0;
  if (order_of(s) == 1) {
    const ComplexDoubleDouble p = add_pole(list, -a0 / a1);
    const double d0 = (RealBall(a0) + RealBall(a1) * RealBall(p.re)).largest();
    return d0 * reciprocal_norm(p) / std::abs(a1.hi) * (1 + 0x1p-40);
  }
  const DoubleDouble discriminant = a1 * a1 - DoubleDouble(4) * a0 * a2;
  if (discriminant < DoubleDouble(0)) {
    const ComplexDoubleDouble p =
        add_pole(list, {-a1 / (DoubleDouble(2) * a2), abs(sqrt(-discriminant) / (DoubleDouble(2) * a2))});
    return relative_change(s, p, conj(p));
  }
  // The larger root by the formula without cancellation, the smaller one from the product.
  const DoubleDouble large =
      (a1 + (a1 < DoubleDouble(0) ? -sqrt(discriminant) : sqrt(discriminant))) * DoubleDouble(-0.5);
  const ComplexDoubleDouble p = add_pole(list, large / a2), r = add_pole(list, a0 / large);
  return relative_change(s, p, r);
}

Series multiplied(const Series& x, const Series& y) {
  Series r(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < y.size() && i + j < r.size(); ++j) r[i + j] = r[i + j] + x[i] * y[j];
  }
  return r;
}

/// x / (y0 + y1 eta).
Series divided(Series x, const ComplexBall& y0, const ComplexBall& y1) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i > 0) x[i] = x[i] - y1 * x[i - 1];
    x[i] = x[i] / y0;
  }
  return x;
}

/// Numerator of a section at w = (w0 + eta)/(1 - eta), times (1 - eta)^order.
Series numerator(const Section& s, const ComplexBall& w0) {
  const ComplexBall b0(RealBall(s.b[0])), b1(RealBall(s.b[1])), b2(RealBall(s.b[2])), one(1.0), two(2.0);
  if (s.a[2] == 0) {
    if (s.a[1] == 0) return {b0 / ComplexBall(RealBall(s.a[0]))};
    return {b0 + b1 * w0, b1 - b0};
  }
  return {b0 + (b1 + b2 * w0) * w0, b1 * (one - w0) + two * (b2 * w0 - b0), b0 - b1 + b2};
}

/// Divides by w - pole; for the pole of the expansion without the factor eta.
Series over_pole(Series x, const ComplexDoubleDouble& pole, const ComplexDoubleDouble& w0) {
  const ComplexBall one(1.0), gap = exact_ball(w0) - exact_ball(pole);
  return pole == w0 ? divided(std::move(x), one + exact_ball(w0), {})
                    : divided(std::move(x), gap, one + exact_ball(pole));
}

/// Every pole as often as it occurs.
std::vector<ComplexDoubleDouble> each(const std::vector<Pole>& poles) {
  std::vector<ComplexDoubleDouble> list;
  for (const Pole& p : poles)
    for (int i = 0; i < p.multiplicity; ++i) {
      list.push_back(p.w);
      if (!p.real()) list.push_back(conj(p.w));
    }
  return list;
}

/// The coefficients of one pole. With eta = (1 - z0 q)(1 - w0)/2 the filter is a ratio of polynomials in eta,
/// and w - w_r becomes (w0 - w_r) + (1 + w_r) eta: differences of poles are computed in w, without
/// cancellation for slow poles.
Mode mode_of(const Filter& filter, const std::vector<Pole>& all, const Pole& pole) {
  const ComplexBall w0 = exact_ball(pole.w), one(1.0);
  Series series(pole.multiplicity);
  series[0] = ComplexBall(RealBall(filter.gain));
  // A division after each factor: with slow poles the product of either exceeds the range of double.
  std::vector<ComplexDoubleDouble> divisors = each(all);
  for (const Section& s : filter.sections) {
    series = multiplied(series, numerator(s, w0));
    const DoubleDouble lead = s.a[order_of(s)];
    if (order_of(s) == 0) continue;
    for (ComplexBall& x : series) x = x / ComplexBall(RealBall(lead));
    for (std::size_t i = 0; i < order_of(s); ++i) {
      series = over_pole(std::move(series), divisors.back(), pole.w);
      divisors.pop_back();
    }
  }
  const FineComplex unit(1.0), w{FineBall::exactly(pole.w.re), FineBall::exactly(pole.w.im)};
  Mode mode{(unit + w) / (unit - w), ComplexBall(-2.0) * w0 / (one - w0), !pole.real(), {}};
  mode.c.resize(series.size());
  const ComplexBall scale = ComplexBall(2.0) / (one - w0);
  ComplexBall power = one;
  for (std::size_t m = 1; m <= series.size(); ++m) {
    power = power * scale;
    mode.c[m - 1] = series[series.size() - m] * power;
  }
  return mode;
}

}  // namespace

RealBall rounded(const FineBall& x) {
  const DoubleDouble mid = to_double_double(x.mid());
  const long double error = (x - FineBall::exactly(mid)).largest();
  return RealBall(mid, static_cast<double>(error) * (1 + 0x1p-50) + RoundingErrors<DoubleDouble>::tiny);
}

FineComplex power(FineComplex z, std::int64_t n) {
  FineComplex result(1.0);
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) result = result * z;
    z = z * z;
  }
  return result;
}

Poles poles(const Filter& filter) {
  Poles result;
  double factor = 1;
  for (const Section& s : filter.sections) factor *= 1 + add_section(result.list, s);
  // A pole z that is 0 but for rounding, as of a delay in a loop, is 0: 1/(1 - z q) is 1 within 2 |z|. The
  // coefficient of its mode would be a quotient of rounding errors.
  constexpr double rounding = 0x1p-90;
  for (Pole& p : result.list) {
    const double modulus = std::sqrt(static_cast<double>(norm(p.z())));
    if (!p.real() || modulus > rounding) continue;
    p.w = ComplexDoubleDouble(-1.0);
    factor *= 1 + 2 * p.multiplicity * modulus;
  }
  result.change = (factor - 1) * (1 + 0x1p-20) + 0x1p-90;
  return result;
}

Modes partial_fractions(const Filter& filter, const std::vector<Pole>& all) {
  Modes result;
  result.from = 1;
  for (const Pole& pole : all) {
    if (pole.w == ComplexDoubleDouble(-1.0)) {
      result.from += static_cast<std::size_t>(pole.multiplicity);
    } else {
      result.modes.push_back(mode_of(filter, all, pole));
    }
  }
  return result;
}

// With n = step k + offset, the sum over m of c_m C(n + m - 1, m - 1) is a polynomial P(k), and P(k) = sum
// d_m C(k + m - 1, m - 1) with d_m = D^(m-1) P(-1), D the back difference.
Mode decimated(const Mode& mode, std::int64_t step, std::int64_t offset) {
  const FineComplex z = power(mode.z, step);
  Mode result{z, rounded(FineComplex(1.0) - z), mode.pair, {}};
  for (std::size_t i = 0; i < mode.c.size(); ++i) {
    const std::int64_t n = offset - step * static_cast<std::int64_t>(i + 1);
    ComplexBall value;  // P(-1 - i)
    RealBall binomial(1.0);
    for (std::size_t m = 0; m < mode.c.size(); ++m) {
      if (m > 0)
        binomial = binomial * RealBall(static_cast<double>(n + static_cast<std::int64_t>(m))) /
                   RealBall(static_cast<double>(m));
      value = value + mode.c[m] * ComplexBall(binomial);
    }
    result.c.push_back(value);
  }
  const ComplexBall start = rounded(power(mode.z, offset));
  for (std::size_t m = 0; m < result.c.size(); ++m) {
    for (std::size_t i = result.c.size() - 1; i > m; --i) result.c[i] = result.c[i - 1] - result.c[i];
    result.c[m] = result.c[m] * start;
  }
  if (result.pair && result.z.im.mid() < Binary256(0)) {  // the upper one of the pair
    result.z = conj(result.z);
    result.one_minus_z = conj(result.one_minus_z);
    for (ComplexBall& c : result.c) c = conj(c);
  }
  return result;
}

}  // namespace qerr
