// Compares the norms of qerr with straightforward implementations: time and relative error.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_filter_norms &&
//   build/tests/bench/bench_filter_norms
//
// H2: a controller canonical form of the expanded coefficients in double, its discrete Lyapunov equation
// solved as one linear system (Eigen, LU). l1 and H2: the difference equation of these coefficients summed in
// double, until the sum is constant or 2e7 terms. Errors of H2 are against the step-down recursion in
// 1200 digits; those of l1 against the middle of qerr's proven interval, whose relative width is given.

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "support/reference_norm.hpp"

namespace {

using namespace qerr;
using reference::Exact;
using reference::Exacts;

struct Coefficients {
  Exacts b{1}, a{1};
};

/// The product of the sections, in z^-1.
Coefficients multiplied_out(const Filter& filter) {
  const auto exact = [](const DoubleDouble& x) { return Exact(x.hi) + Exact(x.lo); };
  const auto in_z = [&](const std::array<DoubleDouble, 3>& c, bool second) {
    const Exact c0 = exact(c[0]), c1 = exact(c[1]), c2 = exact(c[2]);
    return second ? Exacts{c0 + c1 + c2, 2 * (c0 - c2), c0 - c1 + c2} : Exacts{c0 + c1, c0 - c1};
  };
  Coefficients r;
  r.b[0] = exact(filter.gain);
  for (const Section& s : filter.sections) {
    const bool second = !(s.a[2] == 0);
    r.b = reference::product(r.b, in_z(s.b, second));
    r.a = reference::product(r.a, in_z(s.a, second));
  }
  for (Exact& c : r.b) c /= r.a[0];
  for (std::size_t i = r.a.size(); i-- > 0;) r.a[i] /= r.a[0];
  return r;
}

std::vector<double> rounded(const Exacts& exact) {
  std::vector<double> r;
  for (const Exact& c : exact) r.push_back(static_cast<double>(c));
  return r;
}

/// P = A P A' + B B' solved as (I - A (x) A) vec P = vec B B'; ||H||^2 = C P C' + D^2.
double by_lyapunov(const std::vector<double>& b, const std::vector<double>& a) {
  const auto n = static_cast<Eigen::Index>(std::max(a.size(), b.size())) - 1;
  if (n == 0) return std::abs(b[0]);
  const auto at = [](const std::vector<double>& c, Eigen::Index i) {
    return i < static_cast<Eigen::Index>(c.size()) ? c[static_cast<std::size_t>(i)] : 0;
  };
  Eigen::MatrixXd transition = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd output(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    transition(0, i) = -at(a, i + 1);
    output(i) = at(b, i + 1) - at(a, i + 1) * b[0];
    if (i > 0) transition(i, i - 1) = 1;
  }
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(n * n, n * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) system.block(i * n, j * n, n, n) -= transition(i, j) * transition;
  Eigen::VectorXd input = Eigen::VectorXd::Zero(n * n);
  input(0) = 1;
  const Eigen::VectorXd solution = system.partialPivLu().solve(input);
  const Eigen::MatrixXd covariance = Eigen::Map<const Eigen::MatrixXd>(solution.data(), n, n);
  return std::sqrt(output.dot(covariance * output) + b[0] * b[0]);
}

struct Sums {
  double l1 = 0, h2 = 0;
};

Sums by_sum(const std::vector<double>& b, const std::vector<double>& a) {
  constexpr long most = 20'000'000;
  const std::size_t n = std::max(a.size(), b.size());
  std::vector<double> past(n);
  Sums s;
  long idle = 0;
  for (long k = 0; k < most && idle < 1000; ++k) {
    double h = k < static_cast<long>(b.size()) ? b[static_cast<std::size_t>(k)] : 0;
    for (std::size_t j = 1; j < a.size(); ++j) h -= a[j] * past[j - 1];
    for (std::size_t j = n - 1; j > 0; --j) past[j] = past[j - 1];
    past[0] = h;
    const double before = s.l1;
    s.l1 += std::abs(h);
    s.h2 += h * h;
    idle = s.l1 == before ? idle + 1 : 0;
  }
  s.h2 = std::sqrt(s.h2);
  return s;
}

template <class Result>
double timed(Result& result, const std::function<Result()>& compute) {
  using Clock = std::chrono::steady_clock;
  int runs = 0;
  const auto start = Clock::now();
  double seconds = 0;
  do {
    result = compute();
    ++runs;
    seconds = std::chrono::duration<double>(Clock::now() - start).count();
  } while (seconds < 0.02);
  return 1e6 * seconds / runs;
}

void row(const std::string& name, const Filter& filter) {
  const Coefficients exact = multiplied_out(filter);
  const std::vector<double> b = rounded(exact.b), a = rounded(exact.a);
  const Exact h2_exact = sqrt(reference::squared_norm(exact.b, exact.a));
  Estimate h2;
  Interval l1;
  double lyapunov = 0;
  Sums sums;
  const double h2_time = timed<Estimate>(h2, [&] { return h2_estimate(filter); });
  const double l1_time = timed<Interval>(l1, [&] { return l1_norm(filter); });
  const double lyapunov_time = timed<double>(lyapunov, [&] { return by_lyapunov(b, a); });
  const double sums_time = timed<Sums>(sums, [&] { return by_sum(b, a); });
  const auto off = [&](double x) { return static_cast<double>(abs(Exact(x) / h2_exact - 1)); };
  const double middle = 0.5 * (l1.lower + l1.upper);
  std::printf("%-36s %9.3g %8.1e | %9.3g %8.1e | %9.3g %8.1e | %10.3g %8.1e %8.1e\n", name.c_str(), h2_time,
              off(h2.value), l1_time, (l1.upper - l1.lower) / l1.upper, lyapunov_time, off(lyapunov),
              sums_time, off(sums.h2), std::abs(sums.l1 / middle - 1));
}

Filter family(const char* name, int derivative, double order, double rate, double cutoff) {
  for (const FilterFamily& f : filter_families())
    if (f.name == name) return f.design({derivative, rate, {{"order", order}, {"cutoff", cutoff}}, {}, {}});
  return {};
}

Filter resonance(double gap, double angle, int sections) {
  const double m = 1 - gap;
  Filter filter{{}, 1, 1000, 0};
  for (int i = 0; i < sections; ++i)
    filter.sections.push_back(section_in_w({1, -1, 0}, {1, -2 * m * std::cos(angle), m * m}));
  return filter;
}

}  // namespace

int main() {
  std::printf("%-36s %18s | %18s | %18s | %28s\n", "", "H2, qerr", "l1, qerr", "H2, Lyapunov",
              "sum in double");
  std::printf("%-36s %9s %8s | %9s %8s | %9s %8s | %10s %8s %8s\n", "filter", "us", "error", "us", "width",
              "us", "error", "us", "H2 error", "l1 error");
  for (const char* name : {"first_order", "butterworth"}) {
    for (const double cutoff : {50.0, 0.1, 1e-4}) {
      for (const auto& [d, n] : {std::pair{1, 1}, {1, 2}, {2, 4}}) {
        char text[64];
        std::snprintf(text, sizeof text, "%s d=%d n=%d, %g Hz at 1 kHz", name, d, n, cutoff);
        row(text, family(name, d, n, 1000, cutoff));
      }
    }
  }
  row("butterworth d=1 n=8, 5 Hz at 1 kHz", family("butterworth", 1, 8, 1000, 5));
  row("pair 1e-4 from the circle, 1 rad", resonance(1e-4, 1, 1));
  row("pair 1e-9 from the circle, 1 rad", resonance(1e-9, 1, 1));
  row("the same pair twice, 1e-2", resonance(1e-2, 1, 2));
  row("the same pair six times, 1e-2", resonance(1e-2, 1, 6));
  row("pair 1e-6 from the circle, 1e-4 rad", resonance(1e-6, 1e-4, 1));
}
