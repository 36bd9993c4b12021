#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cascade.hpp"
#include "qerr/filter/norms.hpp"
#include "sequence.hpp"

namespace qerr {
namespace {

constexpr double fast_modulus = 0.95;  // poles inside: direct summation needs a few thousand terms at most
constexpr std::int64_t max_terms = 60000;  // of a direct sum
constexpr int max_visits = 200000;         // blocks looked at before the interval is left wide
constexpr double negligible = 1e-18;       // of the norm: the tail that is left out and bounded
constexpr double rounding =
    1e-15;  // per section: its coefficients are doubles, a few roundings from the ideal ones
constexpr int taylor_order = 12;
constexpr double unit_wide = 0x1p-98;  // relative error of a few double-double operations, generously

/// Sum of |x_k| over a stretch where the sign of x is followed exactly: each run of one sign is a difference
/// of U.
///
/// Whatever signs are assumed, sum s_k x_k <= sum |x_k|: a sign mistaken for a value that is almost 0 cannot
/// spoil the lower end, and moves the upper end by twice that value only.
class Runs {
 public:
  Runs(const Sequence& x, double condition, double scale)
      : x_(x), sum_(x.transient_of_sum()), condition_(condition), scale_(scale) {
    differences_.push_back(x);
    for (int j = 0; j < taylor_order; ++j) differences_.push_back(differences_.back().difference());
  }

  /// Goes through first..end-1; stops early when the budget is spent.
  void cover(std::int64_t first, std::int64_t end) {
    start_ = next_ = first;
    visit(first, end);
    close(next_);
  }
  Wide total() const { return total_; }
  double error() const { return error_; }
  std::int64_t next() const { return next_; }  ///< the first index not covered

 private:
  bool spent() { return ++visits_ > max_visits; }

  int sign_at(std::int64_t k) {
    const double x = x_.quick_at(k);
    if (std::abs(x) > 1e-12 * x_.bound(k, k)) return x < 0 ? -1 : 1;
    return x_.at(k) < Wide(0) ? -1 : 1;
  }

  void visit(std::int64_t first, std::int64_t end) {
    if (next_ != first) return;  // the budget ended before this block
    if (spent()) return;
    if (end - first <= 3) {
      for (std::int64_t k = first; k < end; ++k) extend(k + 1, sign_at(k));
      return;
    }
    const std::int64_t middle = first + (end - first) / 2;
    const double reach = static_cast<double>(std::max(middle - first, end - 1 - middle)) * 1.001;
    const double x = x_.quick_at(middle);
    if (std::abs(x) > reach * differences_[1].bound(first, end - 1) + 1e-12 * x_.bound(middle, middle)) {
      extend(end, x < 0 ? -1 : 1);
      return;
    }
    const double slope = differences_[1].quick_at(middle);
    if (std::abs(slope) >
        reach * differences_[2].bound(first, end - 1) + 1e-12 * differences_[1].bound(middle, middle)) {
      monotone(first, end);
      return;
    }
    if (std::abs(x) < 1e-3 * x_.bound(middle, middle) && settled_by_taylor(first, end, middle)) return;
    visit(first, middle);
    visit(middle, end);
  }

  /// Where the modes almost cancel (a low-pass of high order starts like t^n) the plain bounds are far too
  /// large; the Newton series x_{m+i} = sum_j C(i+j-1, j) (D^j x)_m about the middle sees the cancellation.
  /// Settles a block of one sign, or a negligible one.
  bool settled_by_taylor(std::int64_t first, std::int64_t end, std::int64_t middle) {
    const double reach = static_cast<double>(std::max(middle - first, end - 1 - middle));
    const double here = static_cast<double>(x_.at(middle));
    double change = 0, weight = 1;
    for (int j = 1; j <= taylor_order; ++j) {
      weight *= (reach + j - 1) / j;  // C(reach + j - 1, j), the largest weight on either side
      const Sequence& d = differences_[static_cast<std::size_t>(j)];
      change += 1.001 * weight *
                (j < taylor_order ? std::abs(static_cast<double>(d.at(middle))) : d.bound(first, end - 1));
    }
    const double whole = (std::abs(here) + change) * static_cast<double>(end - first);
    if (std::abs(here) > change) {
      extend(end, here < 0 ? -1 : 1);
    } else if (whole <= 1e-18 * scale_) {
      error_ += whole;
      extend(end, sign_ == 0 ? 1 : sign_);
    } else {
      return false;
    }
    return true;
  }

  /// x is monotone on the block: at most one change of sign, found by bisection.
  void monotone(std::int64_t first, std::int64_t end) {
    const int left = sign_at(first), right = sign_at(end - 1);
    if (left != right) {
      std::int64_t low = first, high = end - 1;
      while (high - low > 1) {
        const std::int64_t k = low + (high - low) / 2;
        (sign_at(k) == left ? low : high) = k;
      }
      extend(high, left);
    }
    extend(end, right);
  }

  void extend(std::int64_t end, int sign) {
    if (sign != sign_) {
      close(next_);
      sign_ = sign;
      start_ = next_;
    }
    next_ = end;
  }

  void close(std::int64_t end) {
    if (end <= start_) return;
    const Wide run = sum_at(end - 1) - sum_at(start_ - 1);
    total_ += sign_ < 0 ? -run : run;
    start_ = end;
  }

  Wide sum_at(std::int64_t k) {
    // z^k by repeated squaring carries about k roundings; close poles amplify those of their residues.
    error_ += unit_wide * (static_cast<double>(k) + 64 * condition_ * condition_) * sum_.bound(k, k);
    return sum_.at(k);
  }

  Sequence x_, sum_;
  std::vector<Sequence> differences_;
  double condition_;
  double scale_;
  Wide total_;
  double error_ = 0;
  std::int64_t start_ = 0;
  std::int64_t next_ = 0;
  int sign_ = 0;
  int visits_ = 0;
};

Interval around(const Filter& filter, Wide total, double below, double above) {
  const double value = static_cast<double>(total);
  const double doubt = rounding * static_cast<double>(1 + filter.sections.size()) * value;
  return {std::max(0.0, value - below - doubt), value + above + doubt};
}

/// The first power-of-two multiple of a stretch whose tail is negligible beside `scale`.
std::int64_t horizon(const Sequence& x, std::int64_t from, double scale) {
  std::int64_t end = from + 64;
  while (end < (std::int64_t{1} << 50) && !(x.tail(end) <= negligible * scale)) end *= 2;
  return end;
}

/// By runs of one sign; wide where partial fractions are not fit for it.
Interval by_runs(const Filter& filter, double h2) {
  const Modes modes = partial_fractions(filter);
  Cascade cascade(filter);
  Wide head;
  for (std::size_t k = 0; k < modes.from; ++k) head += abs(cascade.step(k == 0 ? 1.0 : 0.0));
  const Powers powers(modes.modes);
  const Sequence x(modes.modes, powers);
  const auto from = static_cast<std::int64_t>(modes.from);
  const std::int64_t end = horizon(x, from, h2);
  Runs runs(x, modes.condition, h2);
  runs.cover(from, end);
  // Signs taken as seen near zero may be wrong by the rounding of x itself, a small part of that of its sum.
  const double error = 2 * runs.error() + unit_wide * static_cast<double>(head);
  const double tail = x.tail(runs.next());
  if (!std::isfinite(error + tail)) return {0, std::numeric_limits<double>::infinity()};
  return around(filter, head + runs.total(), error, error + tail);
}

/// The coefficients in w of c(q/r), where c(q) is (1 + q)^order times the polynomial c in w = (1 - q)/(1 +
/// q).
std::array<Wide, 3> weighted(const std::array<Wide, 3>& c, bool second, double r) {
  if (!second) {
    const Wide q0 = Wide(c[0]) + c[1], q1 = (Wide(c[0]) - c[1]) / r;
    return {q0 + q1, q0 - q1, 0};
  }
  const Wide q0 = Wide(c[0]) + c[1] + c[2], q1 = Wide(2) * (Wide(c[0]) - c[2]) / r;
  const Wide q2 = (Wide(c[0]) - c[1] + c[2]) / (Wide(r) * r);
  return {q0 + q1 + q2, Wide(2) * (q0 - q2), q0 - q1 + q2};
}

/// ||H(r z)||_2: the impulse response of H(r z) is h_k r^-k.
/// @pre r exceeds the modulus of every pole by more than rounding
double weighted_norm(const Filter& filter, double r) {
  Filter scaled = filter;
  for (Section& s : scaled.sections) {
    const bool second = s.a[2] != 0;
    s = {weighted(s.b, second, r), weighted(s.a, second, r)};
  }
  return h2_norm(scaled);
}

/// By direct summation in double-double; tail sum_{k>=K} |h_k| <= r^K (1 - r^2)^(-1/2) ||H(r z)||_2 (Cauchy
/// and Schwarz).
Interval by_terms(const Filter& filter, double modulus, double h2) {
  const double r = modulus == 0 ? 0x1p-4 : std::max(0.5 * (1 + modulus), 0.25);
  const double weight = weighted_norm(filter, r) / std::sqrt(1 - r * r);
  const double wanted = std::ceil(std::log(negligible * h2 / weight) / std::log(r));
  const auto count = static_cast<std::int64_t>(std::clamp(wanted, 8.0, static_cast<double>(max_terms)));
  Cascade cascade(filter);
  Wide total;
  for (std::int64_t k = 0; k < count; ++k) total += abs(cascade.step(k == 0 ? 1.0 : 0.0));
  const double tail = 1.0001 * weight * std::pow(r, static_cast<double>(count));
  // Each step's error, 2^-98 of the state, lives for about 1/(1 - r) samples and is bounded by the weighted
  // response.
  const double error = unit_wide * static_cast<double>(count) * weight / (1 - r);
  return around(filter, total, error, error + tail);
}

double width(const Interval& i) { return i.upper - i.lower; }

}  // namespace

Interval l1_norm(const Filter& filter) {
  if (!filter.taps.empty()) {
    Wide total;
    for (const double h : filter.taps) total += abs(Wide(h));
    return around(filter, total * abs(filter.gain), 0, 0);
  }
  const double h2 = h2_norm(filter);
  if (h2 == 0) return {0, 0};
  const double modulus = poles_max_modulus(filter);
  if (modulus < fast_modulus) return by_terms(filter, modulus, h2);
  const Interval runs = by_runs(filter, h2);
  if (width(runs) <= 1e-13 * runs.upper) return runs;
  const Interval terms = by_terms(filter, modulus, h2);
  // Both hold the norm.
  return {std::max(runs.lower, terms.lower), std::min(runs.upper, terms.upper)};
}

}  // namespace qerr
