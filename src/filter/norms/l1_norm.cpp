#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/design/design_rounding.hpp"
#include "filter/design/rational.hpp"
#include "filter/norms/direct_sum.hpp"
#include "filter/norms/modes.hpp"
#include "filter/norms/sequence.hpp"
#include "filter/norms/tail_sum.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

constexpr double fast_modulus = 0.95;  // poles inside: direct summation needs a few thousand terms at most
constexpr std::int64_t most_direct = 8'000'000;  // terms times sections of a direct sum: about half a second
constexpr std::int64_t most_runs = 3'000'000;    // blocks of runs times modes: a second at most
constexpr double negligible = 1e-18;             // of the norm: the tail that is left out and bounded
constexpr double narrow = 1e-13;  // relative width with which the search for a better interval ends

double width(const Interval& i) { return (i.upper - i.lower) / i.upper; }

Interval anything() { return {0, std::numeric_limits<double>::infinity()}; }

/// Both hold the norm.
Interval both(const Interval& x, const Interval& y) {
  return {std::max(x.lower, y.lower), std::min(x.upper, y.upper)};
}

/// value - below .. value + above, rounded outwards; anything when not finite.
Interval around(double value, double below, double above) {
  if (!std::isfinite(value) || !std::isfinite(below + above)) return anything();
  constexpr double ulp = 0x1p-52;
  return {std::max(0.0, (value - below) * (1 - ulp)), (value + above) * (1 + ulp)};
}

Interval around(const RealBall& value, double below, double above) {
  const double rad = value.rad() + std::abs(value.mid().lo);
  return around(value.mid().hi, below + rad, above + rad);
}

/// One filter, and the ways to sum its impulse response.
class Search {
 public:
  Search(const Filter& filter, double h2)
      : stages_(static_cast<std::int64_t>(filter.sections.size())),
        poles_(poles(filter)),
        modulus_(largest_modulus()),
        h2_(h2),
        direct_(filter, lift()) {
    if (fast()) return;
    modes_ = partial_fractions(filter, poles_.list);
  }

  /// The norm is never below the H2 norm, and by Cauchy and Schwarz not above `tail(0)`.
  Interval by_size() const { return {h2_ * (1 - 1e-12), direct_.tail(0)}; }  // h2_ is exact but for 1e-15

  /// Directly, as far as that goes.
  Interval by_terms() const {
    const double fall = std::log(direct_.tail(0) / (negligible * h2_)) / std::log1p(lift());
    const auto count = static_cast<std::int64_t>(
        std::clamp(std::ceil(fall), 8.0, static_cast<double>(most_direct / stages_)));
    const PartialSum p = direct_.sum(count);
    return around(p.sum, p.error, p.error + direct_.tail(count));
  }

  /// From the first sample that the partial fractions give on by these alone.
  Interval by_modes() const { return by_modes_from(first(), most_runs); }

  /// Directly until one mode is left, if that is not too long, and then by partial fractions.
  Interval by_terms_and_modes() const {
    const std::int64_t latest = std::max(first(), most_direct / stages_);
    return by_modes_from(slowest_alone_from(modes_.modes, first(), latest, h2_), most_runs / 10);
  }

  bool fast() const { return modulus_ < fast_modulus; }
  /// Whether the partial fractions keep their digits: poles next to each other may not.
  bool separable() const { return Sequence(modes_.modes, Powers(modes_.modes)).trusted(); }

 private:
  Interval by_modes_from(std::int64_t from, std::int64_t work) const {
    const PartialSum head = direct_.sum(from);
    const TailSum rest = tail_sum(modes_.modes, from, h2_, work);
    const double error = rest.error + head.error;
    return moved(around(rest.sum + RealBall(head.sum), error, error + rest.beyond));
  }
  double lift() const { return std::min(1.0, 0.5 * gap_); }
  std::int64_t first() const { return static_cast<std::int64_t>(modes_.from); }

  /// Also finds the gap 1/|z| - 1 of the slowest pole, from below.
  double largest_modulus() {
    double largest = 0;
    gap_ = std::numeric_limits<double>::infinity();
    for (const Pole& p : poles_.list) {
      const ComplexBall one(1.0), w = exact_ball(p.w);
      gap_ = std::min(gap_, one_minus_modulus(ComplexBall(-2.0) * w / (one - w)));
      largest = std::max(largest, std::sqrt(static_cast<double>(norm(p.z()))));
    }
    return largest;
  }

  /// What putting the poles on their places changed.
  Interval moved(const Interval& i) const {
    return {i.lower * (1 - poles_.moved), i.upper * (1 + poles_.moved)};
  }

  std::int64_t stages_ = 1;
  Poles poles_;
  double gap_ = 0;
  double modulus_ = 0;
  double h2_ = 0;
  DirectSum direct_;
  Modes modes_;
};

/// H(-z), whose impulse response is (-1)^k h_k: 1/w for w, which brings poles near z = -1 to z = 1.
Filter reflected(Filter filter) {
  for (Section& s : filter.sections) {
    const auto order = static_cast<std::ptrdiff_t>(order_of(s));
    std::reverse(s.b.begin(), s.b.begin() + order + 1);
    std::reverse(s.a.begin(), s.a.begin() + order + 1);
  }
  return filter;
}

bool slowest_turns_most(const Filter& filter) {
  ComplexDoubleDouble slowest;
  for (const Pole& p : poles(filter).list) {
    if (norm(slowest) < norm(p.z())) slowest = p.z();
  }
  return slowest.re < DoubleDouble(0);
}

Interval best(const Filter& filter) {
  const double h2 = h2_norm(filter);
  if (h2 == 0) return {0, 0};
  if (filter.sections.empty()) {
    const double gain = std::abs(filter.gain.hi);
    return around(gain, 0x1p-50 * gain, 0x1p-50 * gain);
  }
  const Search search(slowest_turns_most(filter) ? reflected(filter) : filter, h2);
  Interval i = search.by_size();
  // |H| is never above the norm: quotients of double-double at z = 1 and, reflected, at z = -1.
  for (const Filter& f : {filter, reflected(filter)})
    i.lower = std::max(i.lower, std::abs(dc_gain(f)) * (1 - 1e-12));
  if (search.fast()) return both(i, search.by_terms());
  if (!search.separable()) return both(i, search.by_terms());
  i = both(i, search.by_modes());
  return width(i) <= narrow ? i : both(i, search.by_terms_and_modes());
}

Interval of_taps(const Filter& filter) {
  RealBall total;
  for (const double h : filter.taps) total += abs(RealBall(h));
  return around(total * abs(RealBall(filter.gain)), 0, 0);
}

}  // namespace

Interval l1_norm(const Filter& filter) {
  const Interval i = filter.taps.empty() ? best(filter) : of_taps(filter);
  const double doubt = design_rounding(filter) * i.upper;
  return {std::max(0.0, i.lower - doubt - filter.deviation.l1), i.upper + doubt + filter.deviation.l1};
}

}  // namespace qerr
