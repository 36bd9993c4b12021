#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "qerr/filter/norms.hpp"
#include "rational.hpp"
#include "runs.hpp"
#include "terms.hpp"
#include "turns.hpp"

namespace qerr {
namespace {

constexpr double fast_modulus = 0.95;  // poles inside: direct summation needs a few thousand terms at most
constexpr std::int64_t most_exact = 1'000'000;  // terms times sections of a direct sum in double-double
constexpr std::int64_t most_quick = 6'000'000;  // and in double: both about 0.1 s
constexpr double most_turns = 20'000;           // of a pair of poles, before its runs are too many
constexpr std::int64_t longest = std::int64_t{1} << 50;
constexpr double negligible = 1e-18;  // of the norm: the tail that is left out and bounded
constexpr double narrow = 1e-13;      // relative width with which the search for a better interval ends
// Per section, for the filter that a family means: its coefficients are doubles, a few roundings from the
// ideal.
constexpr double rounding = 1e-15;

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

Interval around(const Sure& value, double below, double above) {
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
        terms_(filter, lift()) {
    if (fast()) return;
    modes_ = partial_fractions(filter, poles_.list);
    powers_.emplace(modes_.modes);
    whole_.emplace(modes_.modes, *powers_);
  }

  /// The norm is never below the H2 norm, and by Cauchy and Schwarz not above `tail(0)`.
  Interval by_size() const { return {h2_ * (1 - 1e-12), terms_.tail(0)}; }  // h2_ is exact but for 1e-15

  /// Directly, in double-double where that is not too much work, else in double and as far as that goes.
  Interval by_terms() const {
    const double fall = std::log(terms_.tail(0) / (negligible * h2_)) / std::log1p(lift());
    const auto count = static_cast<std::int64_t>(
        std::clamp(std::ceil(fall), 8.0, static_cast<double>(most_quick / stages_)));
    const Partial p = summed(count);
    return around(p.sum, p.error, p.error + terms_.tail(count));
  }

  /// By runs of one sign: O(1) per change of sign.
  Interval by_runs() const {
    if (fast() || !whole_->trusted()) return anything();
    if (std::any_of(modes_.modes.begin(), modes_.modes.end(),
                    [](const Mode& m) { return turns(m) > most_turns; }))
      return anything();
    const Partial head = terms_.in_double_double(first());
    const Stretch s = sum_of_runs(*whole_, h2_, first(), horizon(*whole_, first()));
    const double error = s.error + head.error;
    return moved(around(s.sum + Sure(head.sum), error, error + whole_->tail(s.next)));
  }

  /// Head directly, then the one pair of poles that is left, by its turns; what others are left too only
  /// widens the interval. Empty where the slowest poles are not such a pair.
  std::optional<Interval> by_turns() const {
    if (fast() || !whole_->trusted()) return std::nullopt;
    const auto slowest =
        std::min_element(modes_.modes.begin(), modes_.modes.end(),
                         [](const Mode& x, const Mode& y) { return distance(x) < distance(y); });
    if (!slowest->pair || slowest->c.size() != 1) return std::nullopt;
    const std::vector<Mode> pair{*slowest};
    std::vector<Mode> rest(modes_.modes.begin(), slowest);
    rest.insert(rest.end(), slowest + 1, modes_.modes.end());
    const Powers of_pair(pair), of_rest(rest);
    const Sequence others(rest, of_rest), left(pair, of_pair);
    std::int64_t from = first();
    while (others.tail(from) > 1e-16 * h2_ && from < most_quick / stages_) from += from / 4 + 1;
    from = std::max(first(), std::min(from, most_quick / stages_));
    const Partial head = summed(from);
    const std::int64_t end = horizon(left, from);
    const double error = head.error + others.tail(from);
    return moved(around(sum_of_turns(*slowest, from, end) + Sure(head.sum), error, error + left.tail(end)));
  }

  bool fast() const { return modulus_ < fast_modulus; }

 private:
  Partial summed(std::int64_t count) const {
    return count <= most_exact / stages_ ? terms_.in_double_double(count) : terms_.in_double(count);
  }
  static double distance(const Mode& m) { return one_minus_modulus(m.one_minus_z); }
  static double turns(const Mode& m) {
    return std::abs(std::atan2(m.z.im.mid().hi, m.z.re.mid().hi)) / distance(m);
  }
  double lift() const { return std::min(1.0, 0.5 * gap_); }
  std::int64_t first() const { return static_cast<std::int64_t>(modes_.from); }

  /// Also finds the gap 1/|z| - 1 of the slowest pole, from below.
  double largest_modulus() {
    double largest = 0;
    gap_ = std::numeric_limits<double>::infinity();
    for (const Pole& p : poles_.list) {
      const SureComplex one(1.0), w = sure(p.w);
      gap_ = std::min(gap_, one_minus_modulus(SureComplex(-2.0) * w / (one - w)));
      largest = std::max(largest, std::sqrt(static_cast<double>(norm(p.z()))));
    }
    return largest;
  }

  /// What putting the poles on their places changed.
  Interval moved(const Interval& i) const {
    return {i.lower * (1 - poles_.moved), i.upper * (1 + poles_.moved)};
  }

  /// A length after which the tail is negligible.
  std::int64_t horizon(const Sequence& x, std::int64_t from) const {
    std::int64_t end = from + 64;
    while (end < longest && !(x.tail(end) <= negligible * h2_)) end *= 2;
    return end;
  }

  std::int64_t stages_ = 1;
  Poles poles_;
  double gap_ = 0;
  double modulus_ = 0;
  double h2_ = 0;
  Terms terms_;
  Modes modes_;
  std::optional<Powers> powers_;
  std::optional<Sequence> whole_;
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
  WideComplex slowest;
  for (const Pole& p : poles(filter).list) {
    if (norm(slowest) < norm(p.z())) slowest = p.z();
  }
  return slowest.re < Wide(0);
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
  i = both(i, search.by_runs());
  if (width(i) <= narrow) return i;
  const auto turns = search.by_turns();
  return both(i, turns ? *turns : search.by_terms());
}

Interval of_taps(const Filter& filter) {
  Sure total;
  for (const double h : filter.taps) total += abs(Sure(h));
  return around(total * abs(Sure(filter.gain)), 0, 0);
}

}  // namespace

Interval l1_norm(const Filter& filter) {
  const Interval i = filter.taps.empty() ? best(filter) : of_taps(filter);
  const double doubt = rounding * static_cast<double>(1 + filter.sections.size()) * i.upper;
  return {std::max(0.0, i.lower - doubt - filter.deviation.l1), i.upper + doubt + filter.deviation.l1};
}

}  // namespace qerr
