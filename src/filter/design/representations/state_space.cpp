#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/design/families/families.hpp"
#include "filter/design/ratio.hpp"
#include "filter/design/representations/representations.hpp"

namespace qerr {
namespace {

using Vector = std::vector<Binary1024>;
using Matrix = std::vector<Vector>;

constexpr int most_dc_zeros = 4;  // zeros at z = 1 that are recognized despite rounding
constexpr std::size_t max_states = 20;
constexpr double negligible = 1e-290;  // a pole this near to z = 1 or -1 in w is on the circle
constexpr double half_unit = 0.5 * std::numeric_limits<double>::epsilon();

/// Numerator and denominator in ascending powers of z, by Faddeev and Le Verrier: M_n = I,
/// p_(k-1) = -tr(A M_k)/(n - k + 1), M_(k-1) = A M_k + p_(k-1) I, numerator_(k-1) = C M_k B + D p_(k-1).
struct TransferFunction {
  Vector b, a;
};

TransferFunction transfer_function(const Rows& rows, const Vector& b, const Vector& c, const Binary1024& d) {
  const std::size_t n = rows.size();
  Matrix m(n, Vector(n));
  for (std::size_t i = 0; i < n; ++i) m[i][i] = 1;
  TransferFunction h{Vector(n + 1), Vector(n + 1)};
  h.a[n] = 1;
  h.b[n] = d;
  for (std::size_t k = n; k > 0; --k) {
    Matrix next(n, Vector(n));
    Binary1024 trace = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        h.b[k - 1] += c[i] * m[i][j] * b[j];
        for (std::size_t l = 0; l < n; ++l) {
          if (rows[i][l] != 0) next[i][j] += rows[i][l] * m[l][j];
        }
      }
      trace += next[i][i];
    }
    h.a[k - 1] = -trace / static_cast<double>(n - k + 1);
    h.b[k - 1] += d * h.a[k - 1];
    for (std::size_t i = 0; i < n; ++i) next[i][i] += h.a[k - 1];
    m = std::move(next);
  }
  return h;
}

/// Solves (I - A) x = b for x by Gaussian elimination with row pivots.
Vector solved(const Rows& a, Vector b) {
  const std::size_t n = a.size();
  Matrix m(n, Vector(n));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) m[i][j] = (i == j ? 1 : 0) - Binary1024(a[i][j]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t top = k;
    for (std::size_t i = k; i < n; ++i) {
      if (abs(m[i][k]) > abs(m[top][k])) top = i;
    }
    std::swap(m[k], m[top]);
    std::swap(b[k], b[top]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const Binary1024 factor = m[i][k] / m[k][k];
      for (std::size_t j = k; j < n; ++j) m[i][j] -= factor * m[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= m[k][j] * b[j];
    b[k] /= m[k][k];
  }
  return b;
}

/// Number of zeros at z = 1 within the rounding of C and D: with R = (I - A)^-1 the filter is
/// D + C R B - C R^2 B (z - 1) + ..., and a sum that is 0 within rounding is taken as 0.
std::size_t zeros_at_dc(const Rows& a, const Vector& b, const Vector& c, const Binary1024& d) {
  std::size_t zeros = 0;
  Vector v = b;
  for (; zeros <= most_dc_zeros; ++zeros) {
    v = solved(a, v);
    Binary1024 sum = zeros == 0 ? d : Binary1024(0), size = abs(sum);
    for (std::size_t i = 0; i < v.size(); ++i) {
      sum += c[i] * v[i];
      size += abs(c[i] * v[i]);
    }
    if (size == 0 || abs(sum) > size * (static_cast<double>(v.size() + 1) * 2 * half_unit)) break;
  }
  return zeros;
}

Error wrong_shape(const char* key, const std::string& rule, const Rows& found) {
  return Error(key, rule,
               std::to_string(found.size()) + " rows, the first of " +
                   std::to_string(found.empty() ? 0 : found[0].size()),
               "write {A: [[a11, a12], [a21, a22]], B: [b1, b2], C: [c1, c2], D: d}");
}

/// The largest sum of absolute values in a row of A.
/// @throws Error (input; key `A`) unless A is square, of 1 to max_states rows, and with row sums up to 1e10
double largest_row_sum(const Rows& a) {
  if (a.empty() || a.size() > max_states)
    throw wrong_shape("A", "must have 1 to " + std::to_string(max_states) + " rows", a);
  double size = 1;
  for (const auto& row : a) {
    if (row.size() != a.size()) throw wrong_shape("A", "must be square", a);
    double sum = 0;
    for (const double x : row) sum += std::abs(x);
    size = std::max(size, sum);
  }
  if (size > 1e10) throw Error("A", "the numbers are too large", figure(size), "scale the states");
  return size;
}

/// A column, or a row, of n numbers.
Vector vector_of(const Rows& rows, std::size_t n, const char* key) {
  Vector v;
  const bool row = rows.size() == 1 && rows[0].size() == n;
  const bool column =
      rows.size() == n && std::ranges::all_of(rows, [](const auto& r) { return r.size() == 1; });
  if (!row && !column) throw wrong_shape(key, "needs one number per state: one input, one output", rows);
  for (const auto& r : rows) v.insert(v.end(), r.begin(), r.end());
  return v;
}

Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  const Rows d = values.contains("D") ? values.at("D") : Rows{{0.0}};
  return filter_from_state_space(values.at("A"), values.at("B"), values.at("C"), d, sample_rate, derivative);
}

}  // namespace

Filter filter_from_state_space(const Rows& a, const Rows& b, const Rows& c, const Rows& d, double sample_rate,
                               int derivative) {
  check_sample_rate(sample_rate);
  check_derivative(derivative);
  check_finite(a, "A");
  check_finite(b, "B");
  check_finite(c, "C");
  check_finite(d, "D");
  const std::size_t n = a.size();
  const double size = largest_row_sum(a);
  const Vector input = vector_of(b, n, "B"), output = vector_of(c, n, "C"), through = vector_of(d, 1, "D");
  const TransferFunction h = transfer_function(a, input, output, through[0]);
  // Descending in z is ascending in z^-1.
  const Vector below_w = in_w({h.a.rbegin(), h.a.rend()});
  Binary1024 scale = 0;
  for (const Binary1024& x : below_w) scale = std::max(scale, Binary1024(abs(x)));
  // The first (last) coefficient is 0 for a pole at z = 1 (-1).
  const bool on_circle =
      std::min(Binary1024(abs(below_w[0])), Binary1024(abs(below_w[n]))) <= scale * negligible;
  const Factored below = factored(below_w);
  bool stable = false;
  double modulus = largest_modulus(below.roots, 2 * half_unit * size, stable);
  if (on_circle) modulus = std::max(1.0, modulus);
  if (!stable || on_circle) throw unstable("A", modulus);
  Vector above_w = in_w({h.b.rbegin(), h.b.rend()});
  if (std::ranges::all_of(above_w, [](const Binary1024& x) { return x == 0; }))
    return {{}, 1, sample_rate, derivative, {0}};
  // A filter that blocks 0 Hz up to the rounding of C and D is taken to block it, unless that changes its
  // norm.
  Filter filter;
  const std::size_t blocked = std::min(zeros_at_dc(a, input, output, through[0]), n);
  for (const std::size_t zeros : {blocked, std::size_t(0)}) {
    Vector numerator = above_w;
    std::fill_n(numerator.begin(), zeros, Binary1024(0));
    const Factored above = factored(numerator);
    filter =
        filter_from_factors(above.lead / below.lead, above.factors, below.factors, sample_rate, derivative);
    if (set_deviation(filter, {h.b.rbegin(), h.b.rend()}, {h.a.rbegin(), h.a.rend()}, modulus, "A")) break;
  }
  return filter;
}

FilterRepresentation state_space_representation() {
  return {"state_space",
          "in place of lowpass: x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k",
          key::object("state_space", "one input, one output"),
          {{.name = "A", .kind = Kind::matrix, .meaning = "rows of the state matrix", .required = true},
           {.name = "B", .kind = Kind::matrix, .meaning = "one number per state", .required = true},
           {.name = "C", .kind = Kind::matrix, .meaning = "one number per state", .required = true},
           {.name = "D", .kind = Kind::matrix, .meaning = "direct path; default: 0"}},
          {},
          build};
}

}  // namespace qerr
