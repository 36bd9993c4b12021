#include "filter/norms/sign_runs.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {
namespace {

constexpr double taylor_visits = 20;  // time of `sum_by_taylor` relative to a block of simple modes
// Below this ratio of |x| to its bound, bisection by the bound takes too many blocks.
constexpr double cancelled = 0.01;

/// Sum of |x_k| by runs of one sign, each a difference of two values of U = transient_of_sum.
///
/// sum s_k x_k <= sum |x_k| for all signs s_k: a wrong sign of a value near 0 does not affect the lower
/// bound, and the upper bound by twice that value.
class SignRuns {
 public:
  SignRuns(const Sequence& x, const Powers& powers, double scale, std::int64_t visits)
      : x_(x),
        sum_(x.transient_of_sum()),
        differences_(x),
        powers_(powers),
        scale_(scale),
        visits_(visits),
        visits_of_taylor_(static_cast<std::int64_t>(taylor_visits * x.mean_multiplicity())) {}

  /// Sums over first..end-1; stops early when no visits remain.
  void cover(std::int64_t first, std::int64_t end) {
    start_ = next_ = first;
    sum_before_ = sum_.at(first - 1);
    visit(first, end);
    close(next_);
  }
  RunsSum result() const { return {total_, 2 * error_, next_, std::max<std::int64_t>(visits_, 0)}; }

 private:
  bool spent() { return --visits_ < 0; }

  /// The sign of x_k. Where it is uncertain, `count` values up to |x_k| are added to the error.
  int sign_at(std::int64_t k, std::int64_t count) {
    powers_.quick(k, power_);
    const double quick = x_.quick_at(k, power_);
    if (std::abs(quick) > 1e-12 * x_.bound(k, k)) return quick < 0 ? -1 : 1;
    const RealBall x = x_.at(k);
    if (!x.above_zero() && !x.below_zero()) error_ += x.largest() * static_cast<double>(count);
    return x.mid() < DoubleDouble(0) ? -1 : 1;
  }

  void visit(std::int64_t first, std::int64_t end) {
    if (next_ != first) return;  // stopped before this block
    if (spent()) return;
    if (end - first <= 3) {
      for (std::int64_t k = first; k < end; ++k) extend(k + 1, sign_at(k, 1));
      return;
    }
    const std::int64_t middle = first + (end - first) / 2;
    const double radius = static_cast<double>(std::max(middle - first, end - 1 - middle)) * 1.001;
    powers_.quick(middle, power_);
    powers_.moduli(first, moduli_);
    const double x = x_.quick_at(middle, power_), size = x_.bound(moduli_, middle);
    const double steepest = differences_.first().bound(moduli_, end - 1);
    if (std::abs(x) > radius * steepest + 1e-12 * size) {
      extend(end, x < 0 ? -1 : 1);
      return;
    }
    const double slope = differences_.first().quick_at(middle, power_);
    if (std::abs(slope) > radius * differences_.second().bound(moduli_, end - 1) + 1e-12 * steepest) {
      monotone(first, end);
      return;
    }
    if (std::abs(x) < cancelled * size && sum_by_taylor(first, end, middle)) return;
    visit(first, middle);
    visit(middle, end);
  }

  /// Where the modes almost cancel the other bounds are much too large.
  /// @returns whether the block has one sign, or is negligible; then it is summed
  bool sum_by_taylor(std::int64_t first, std::int64_t end, std::int64_t middle) {
    visits_ -= visits_of_taylor_;
    const std::vector<ComplexBall> powers = powers_.proven(middle);
    const RealBall center = x_.at(middle, powers);
    const double change = differences_.variation(first, end, middle, powers);
    const double total = (center.largest() + change) * static_cast<double>(end - first);
    if (center.smallest() > change) {
      extend(end, center.mid() < DoubleDouble(0) ? -1 : 1);
    } else if (total <= 1e-18 * scale_) {
      error_ += total;
      extend(end, sign_ == 0 ? 1 : sign_);
    } else {
      return false;
    }
    return true;
  }

  /// x is monotone on the block: at most one change of sign, found by bisection.
  void monotone(std::int64_t first, std::int64_t end) {
    const int left = sign_at(first, end - first), right = sign_at(end - 1, end - first);
    if (left != right) {
      std::int64_t low = first, high = end - 1;
      while (high - low > 1) {
        const std::int64_t k = low + (high - low) / 2;
        (sign_at(k, high - low) == left ? low : high) = k;
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
    const RealBall sum = sum_.at(end - 1), run = sum - sum_before_;
    sum_before_ = sum;
    total_ += sign_ < 0 ? -run : run;
    start_ = end;
  }

  Sequence x_, sum_;
  Differences differences_;
  const Powers& powers_;
  std::vector<std::complex<double>> power_;  // z^k of all modes at the current sample
  std::vector<double> moduli_;
  double scale_;
  RealBall total_;
  RealBall sum_before_;  // before the current run
  double error_ = 0;
  std::int64_t start_ = 0;
  std::int64_t next_ = 0;
  int sign_ = 0;
  std::int64_t visits_;  // remaining blocks
  std::int64_t visits_of_taylor_;
};

}  // namespace

RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits) {
  SignRuns runs(x, powers, scale, visits);
  runs.cover(first, end);
  return runs.result();
}

}  // namespace qerr
