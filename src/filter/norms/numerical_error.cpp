#include "filter/norms/numerical_error.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/norms/rational.hpp"
#include "qerr/filter/norms.hpp"

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

using Numerator = std::array<DoubleDouble, 3>;
using PlanSection = NormalizedSection<DoubleDouble>;
using Sections = std::vector<Section>;

/// Where a section rounds, and what it adds: the columns and rows of the matrices below.
enum Sum { low, band, high, state_1, state_2, sums };

Section section_of(const PlanSection& s) {
  const DoubleDouble one = 1;
  return s.second ? Section{{s.b0, s.b1, s.b2}, {s.k0, s.k1 - s.k0, one - s.k1}}
                  : Section{{s.b0, s.b1, 0}, {s.k0, one - s.k0, 0}};
}

double l1_of(const Sections& sections, double sample_rate) {
  for (const Section& s : sections)
    if (s.b == Numerator{}) return 0;
  Filter filter;
  filter.sections = sections;
  filter.sample_rate = sample_rate;
  return l1_norm(filter).upper;
}

/// The numerator over P from an error of `at` to an output with the numerator Q over P.
Numerator passed(const Section& s, bool second, Sum at, const Numerator& q) {
  const auto& a = s.a;
  const DoubleDouble half = 0.5, m10 = a[1] * q[0] - a[0] * q[1], m20 = a[2] * q[0] - a[0] * q[2],
                     m21 = a[2] * q[1] - a[1] * q[2];
  const DoubleDouble zero = 0, a01 = a[0] + a[1];
  if (at == high) return q;
  if (!second) {
    if (at == low) return {q[0] * a[0], q[0] * a[1], zero};
    return at == state_1 ? Numerator{half * m10, zero - half * m10, zero} : Numerator{};
  }
  switch (at) {
    case band:
      return {a01 * q[0], a01 * q[1] + m20, a01 * q[2] + m21};
    case low:
      return {a[0] * q[0] + half * m10, a[0] * q[1] + half * (m10 + m20), a[0] * q[2] + half * m20};
    case state_1:
      return {half * m20, half * (m21 - m20), zero - half * m21};
    default:
      return {half * m10, half * (m20 - m10), zero - half * m20};
  }
}

/// The numerators over P of the sums themselves; those of the states are exact up to the errors of their
/// sums, which are added.
Numerator numerator_of(Sum sum, bool second) {
  switch (sum) {
    case low:
      return {1, 0, 0};
    case band:
    case high:
      return sum == high && second ? Numerator{0, 0, 1} : Numerator{0, 1, 0};
    case state_1:
      return second ? Numerator{0, 1, -1} : Numerator{1, -1, 0};
    default:
      return second ? Numerator{1, -1, 0} : Numerator{};
  }
}

using Values = Eigen::Matrix<double, sums, 1>;
using Matrix = Eigen::Matrix<double, sums, sums>;

/// Errors of the sums, in u, that are in proportion to the sums: of `high` by the products with k0 and k1,
/// which count their factor's rounding, their own, and one of the differences; of the state that a constant
/// input sets two at the start, x/k0.
Matrix roundings(const PlanSection& s) {
  const double k0 = std::abs(static_cast<double>(s.k0)), k1 = std::abs(static_cast<double>(s.k1));
  Matrix m = Matrix::Identity();
  m(high, state_1) = s.second ? 2 * k1 : 2 * k0;
  m(s.second ? state_2 : state_1, s.second ? state_2 : state_1) = 2;
  if (s.second) m(high, state_2) = 3 * k0;
  if (!s.second) m(band, band) = m(state_2, state_2) = 0;
  return m;
}

/// The least bound s = n + u G M s of the sums; infinite without one.
Values bounded_sums(const Values& n, const Matrix& growth) {
  constexpr int iterations = 200;
  Values s = n;
  for (int i = 0; i < iterations; ++i) s = n + growth * s;
  s *= 1 + 1e-9;
  const Values again = n + growth * s;
  return (again.array() <= s.array()).all()
             ? s
             : Values(Values::Constant(std::numeric_limits<double>::infinity()));
}

/// Sum of the products, 0 times infinity being 0.
double weighted(const Values& weights, const Values& values) {
  double sum = 0;
  for (int i = 0; i < sums; ++i)
    if (weights[i] != 0) sum += weights[i] * values[i];
  return sum;
}

struct SectionRounding {
  const std::vector<PlanSection>& plan;
  Sections sections;  ///< the same, as filters
  double rate, u;

  Sections between(std::size_t from, std::size_t to) const {
    return {sections.begin() + from, sections.begin() + static_cast<std::ptrdiff_t>(to)};
  }
  double before(std::size_t i, const Numerator& q) const {
    Sections all = between(0, i);
    all.push_back({q, sections[i].a});
    return l1_of(all, rate);
  }
  double behind(std::size_t i, const Numerator& q) const {
    Sections all = between(i + 1, sections.size());
    all.push_back({q, sections[i].a});
    return l1_of(all, rate);
  }
  double within(std::size_t i, const Numerator& q) const { return l1_of({{q, sections[i].a}}, rate); }

  /// Bounds of section i's sums, and the errors of the sums and of the output in it.
  struct Part {
    Values sums, errors;
    double output = 0;
  };
  /// @param input, off  largest exact input of the section, and its largest error
  Part part(std::size_t i, double input, double off) const {
    Values n = Values::Zero();
    Matrix g = Matrix::Zero();
    for (const Sum row : {low, band, high, state_1, state_2}) {
      const Numerator q = numerator_of(row, plan[i].second);
      n[row] = before(i, q) + within(i, q) * off;
      for (const Sum at : {low, band, high, state_1, state_2})
        g(row, at) = within(i, passed(sections[i], plan[i].second, at, q));
    }
    g(state_1, plan[i].second ? band : low) += 1;
    if (plan[i].second) g(state_2, low) += 1;
    const Matrix m = u * roundings(plan[i]);
    Values of_input = Values::Zero();  // of x - k0 s2
    if (plan[i].second) of_input[high] = u * (input + off);
    Part p;
    p.sums = bounded_sums(n + g * of_input, g * m);
    for (int row = 0; row < sums; ++row)
      p.errors[row] = of_input[row] + weighted(m.row(row).transpose(), p.sums);
    const auto b = [](const DoubleDouble& c) { return std::abs(static_cast<double>(c)); };
    const Values of_output{3 * u * b(plan[i].b0), 4 * u * b(plan[i].b1), 4 * u * b(plan[i].b2), 0, 0};
    p.output = weighted(of_output, p.sums);
    return p;
  }
};

RecursionError of_taps(const FilterPlan<DoubleDouble>& plan, double u) {
  double sum = 0, largest = 1;
  for (const DoubleDouble& tap : plan.taps) sum += std::abs(static_cast<double>(tap));
  largest = std::max(largest, sum);
  // Each product has the roundings of tap, input and itself, and passes at most as many sums as there are.
  return {u * (static_cast<double>(plan.taps.size()) + 3) * sum, largest};
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

FilterPlan<DoubleDouble> levelled_plan(const Filter& filter) {
  FilterPlan<DoubleDouble> plan = filter_plan<DoubleDouble>(filter);
  for (std::size_t i = 0; i + 1 < plan.sections.size(); ++i) {
    NormalizedSection<DoubleDouble>& last = plan.sections.back();
    for (DoubleDouble* b : {&plan.sections[i].b0, &plan.sections[i].b1, &plan.sections[i].b2})
      *b *= plan.sections[i].k0;
    for (DoubleDouble* b : {&last.b0, &last.b1, &last.b2}) *b = *b / plan.sections[i].k0;
  }
  return plan;
}

RecursionError recursion_error(const FilterPlan<DoubleDouble>& plan, double sample_rate,
                               double unit_roundoff) {
  constexpr double products = 1e-4;  // of two roundings, relative to one
  const double u = unit_roundoff * (1 + products);
  if (plan.sections.empty()) return of_taps(plan, u);
  SectionRounding all{plan.sections, {}, sample_rate, u};
  for (const PlanSection& s : plan.sections) all.sections.push_back(section_of(s));
  const std::size_t count = all.sections.size();
  RecursionError result{u * l1_of(all.sections, sample_rate), 1};
  double input = 1, off = u;
  for (std::size_t i = 0; i < count; ++i) {
    const SectionRounding::Part p = all.part(i, input, off);
    const bool second = plan.sections[i].second;
    off = all.within(i, all.sections[i].b) * off + p.output;
    for (const Sum at : {low, band, high, state_1, state_2}) {
      const Numerator q = passed(all.sections[i], second, at, all.sections[i].b);
      if (p.errors[at] == 0) continue;
      result.output += p.errors[at] * all.behind(i, q);
      off += p.errors[at] * all.within(i, q);
      result.largest_signal = std::max(result.largest_signal, p.sums[at]);
    }
    const Sections rest = all.between(i + 1, count);
    result.output += p.output * (rest.empty() ? 1 : l1_of(rest, sample_rate));
    input = l1_of(all.between(0, i + 1), sample_rate);
    result.largest_signal = std::max(result.largest_signal, input);
  }
  return result;
}

}  // namespace qerr
