#include "filter/norms/sign_runs.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {
namespace {

constexpr int taylor_order = 12;
// Where |x| is so small a part of its bound, halving blocks until the bound says enough takes too many.
constexpr double cancelled = 0.01;

/// Sum of |x_k| over a stretch where the sign of x is followed exactly: each run of one sign is a difference
/// of U.
///
/// Whatever signs are assumed, sum s_k x_k <= sum |x_k|: a sign mistaken for a value that is almost 0 cannot
/// spoil the lower end, and moves the upper end by twice that value only.
class Runs {
 public:
  Runs(const Sequence& x, const Powers& powers, double scale, std::int64_t visits)
      : x_(x), sum_(x.transient_of_sum()), powers_(powers), scale_(scale), visits_(visits) {
    differences_.push_back(x);
    for (int j = 0; j < taylor_order; ++j) differences_.push_back(differences_.back().difference());
  }

  /// Goes through first..end-1; stops early when the budget is spent.
  void cover(std::int64_t first, std::int64_t end) {
    start_ = next_ = first;
    sum_before_ = sum_.at(first - 1);
    visit(first, end);
    close(next_);
  }
  RunsSum result() const { return {total_, 2 * error_, next_, std::max<std::int64_t>(visits_, 0)}; }

 private:
  bool spent() { return --visits_ < 0; }

  /// The sign of x_k; where it cannot be told, of `count` values no larger, these are charged as errors.
  int sign_at(std::int64_t k, std::int64_t count) {
    powers_.quick(k, turned_);
    const double quick = x_.quick_at(k, turned_);
    if (std::abs(quick) > 1e-12 * x_.bound(k, k)) return quick < 0 ? -1 : 1;
    const RealBall x = x_.at(k);
    if (!x.above_zero() && !x.below_zero()) error_ += x.largest() * static_cast<double>(count);
    return x.mid() < DoubleDouble(0) ? -1 : 1;
  }

  void visit(std::int64_t first, std::int64_t end) {
    if (next_ != first) return;  // the budget ended before this block
    if (spent()) return;
    if (end - first <= 3) {
      for (std::int64_t k = first; k < end; ++k) extend(k + 1, sign_at(k, 1));
      return;
    }
    const std::int64_t middle = first + (end - first) / 2;
    const double reach = static_cast<double>(std::max(middle - first, end - 1 - middle)) * 1.001;
    powers_.quick(middle, turned_);
    powers_.moduli(first, moduli_);
    const double x = x_.quick_at(middle, turned_), size = x_.bound(moduli_, middle);
    const double steepest = differences_[1].bound(moduli_, end - 1);
    if (std::abs(x) > reach * steepest + 1e-12 * size) {
      extend(end, x < 0 ? -1 : 1);
      return;
    }
    const double slope = differences_[1].quick_at(middle, turned_);
    if (std::abs(slope) > reach * differences_[2].bound(moduli_, end - 1) + 1e-12 * steepest) {
      monotone(first, end);
      return;
    }
    if (std::abs(x) < cancelled * size && settled_by_taylor(first, end, middle)) return;
    visit(first, middle);
    visit(middle, end);
  }

  /// Where the modes almost cancel (a low-pass of high order starts like t^n) the plain bounds are far too
  /// large; the Newton series x_{m+i} = sum_j C(i+j-1, j) (D^j x)_m about the middle sees the cancellation.
  /// Settles a block of one sign, or a negligible one.
  bool settled_by_taylor(std::int64_t first, std::int64_t end, std::int64_t middle) {
    const double reach = static_cast<double>(std::max(middle - first, end - 1 - middle));
    const RealBall here = x_.at(middle);
    double change = 0, weight = 1;
    for (int j = 1; j <= taylor_order; ++j) {
      weight *= (reach + j - 1) / j;  // C(reach + j - 1, j), the largest weight on either side
      const Sequence& d = differences_[static_cast<std::size_t>(j)];
      change += 1.001 * weight * (j < taylor_order ? d.at(middle).largest() : d.bound(first, end - 1));
    }
    const double whole = (here.largest() + change) * static_cast<double>(end - first);
    if (here.smallest() > change) {
      extend(end, here.mid() < DoubleDouble(0) ? -1 : 1);
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
  std::vector<Sequence> differences_;
  const Powers& powers_;
  std::vector<std::complex<double>> turned_;  // the powers at the place looked at
  std::vector<double> moduli_;
  double scale_;
  RealBall total_;
  RealBall sum_before_;  // of the run at hand
  double error_ = 0;
  std::int64_t start_ = 0;
  std::int64_t next_ = 0;
  int sign_ = 0;
  std::int64_t visits_;  // blocks that may still be looked at
};

}  // namespace

RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits) {
  Runs runs(x, powers, scale, visits);
  runs.cover(first, end);
  return runs.result();
}

}  // namespace qerr
