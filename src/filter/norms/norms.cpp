#include "qerr/filter/norms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/norms/modes.hpp"
#include "filter/norms/multiprecision.hpp"
#include "filter/norms/rational.hpp"
#include "filter/norms/sequence.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {
namespace {

constexpr double enough = 0x1p-70;  // relative radius, well below the rounding of the result to double

template <class T>
std::optional<Estimate> estimate(const Ball<T>& norm) {
  const double value = static_cast<double>(norm.mid());
  const auto error = (norm - Ball<T>(value)).largest();
  if (!std::isfinite(value) || !std::isfinite(error)) return std::nullopt;
  // Converting the radius rounds by 2^-53 of it.
  return Estimate{value, static_cast<double>(error) * (1 + 0x1p-50) + std::numeric_limits<double>::min()};
}

/// The norm in numbers of type T; empty unless its relative radius is at most `wanted`. Double-double
/// suffices for all families; a cascade of twelve equal poles 1e-9 from the unit circle needs 1024 bits.
template <class T>
std::optional<Estimate> estimate_in(const Filter& filter, double lift, double wanted) {
  const auto squared = squared_norm(rational<T>(filter, lift));
  if (!squared) return std::nullopt;
  // The gain last: its square may exceed the range of double.
  const Ball<T> norm = sqrt(*squared) * abs(Ball<T>::exactly(filter.gain));
  if (!(static_cast<double>(norm.rad()) <= wanted * static_cast<double>(norm.largest()))) return std::nullopt;
  return estimate(norm);
}

std::optional<Estimate> taps_norm(const Filter& filter) {
  Ball<DoubleDouble> total;
  for (const DoubleDouble& h : filter.taps) total += Ball<DoubleDouble>(h) * Ball<DoubleDouble>(h);
  return estimate(sqrt(total) * abs(Ball<DoubleDouble>(filter.gain)));
}

}  // namespace

Estimate h2_estimate(const Filter& filter) {
  std::optional<Estimate> e;
  if (filter.gain.hi != 0 && std::isfinite(filter.gain.hi)) {
    if (!filter.taps.empty()) e = taps_norm(filter);
    if (!e) e = estimate_in<DoubleDouble>(filter, 0, enough);
    if (!e) e = estimate_in<Binary1024>(filter, 0, enough);
    if (!e) e = estimate_in<Binary<4096>>(filter, 0, 1);
  }
  if (!e)
    throw Error(
        "", "the norms of the filter exceed the range of double precision",
        std::isfinite(filter.gain.hi) ? "a gain of " + shortest(filter.gain.hi) : "a gain above 1.8e308",
        "scale its coefficients, or bring cut-off and sample rate closer together");
  e->error += filter.deviation.h2 + design_rounding(filter) * e->value;
  return *e;
}

double lifted_norm(const Filter& filter, double lift) {
  // One digit suffices.
  std::optional<Estimate> e = estimate_in<DoubleDouble>(filter, lift, 0.1);
  if (!e) e = estimate_in<Binary1024>(filter, lift, 0.1);
  return e ? e->value + e->error : std::numeric_limits<double>::infinity();
}

double h2_norm(const Filter& filter) { return h2_estimate(filter).value; }

Norms norms(const Filter& filter) {
  const Estimate h2 = h2_estimate(filter);
  return {h2.value, h2.error, l1_norm(filter), dc_gain(filter)};
}

namespace {

/// ||.||_1 <= (sum r^2k)^(1/2) ||lifted||_2, r = 1/(1 + lift).
double l1_bound(const Filter& filter, double lift) {
  return lifted_norm(filter, lift) * (1 + lift) / std::sqrt(lift * (2 + lift)) * (1 + 0x1p-40);
}

/// From a disturbance of section i to the output: `numerator` over the section's denominator, times the
/// sections after it.
Filter path(const Filter& filter, std::size_t i, const std::array<DoubleDouble, 3>& numerator) {
  Filter p{{filter.sections.begin() + i, filter.sections.end()}, 1, 1, 0};
  p.sections.front().b = numerator;
  return p;
}

/// (1 - w)/2 times c0 + c1 w.
std::array<DoubleDouble, 3> halved(DoubleDouble c0, DoubleDouble c1) {
  const DoubleDouble half(0.5);
  return {c0 * half, (c1 - c0) * half, -c1 * half};
}

/// Small for a section with a slow pole.
double slow_share(const Section& s) {
  return std::abs(s.a[0].hi) / (std::abs(s.a[0].hi) + std::abs(s.a[1].hi) + std::abs(s.a[2].hi));
}

/// The filter with its sections ordered by speed: after differences, low-passes would reduce numbers whose
/// rounding has been passed on already.
Filter low_passes_first(Filter filter) {
  std::ranges::stable_sort(filter.sections,
                           [](const Section& x, const Section& y) { return slow_share(x) < slow_share(y); });
  return filter;
}

double size(const DoubleDouble& x) { return std::abs(x.hi); }

}  // namespace

// With the signals times S = a0 + a1 + a2, as a NormalizedSection has them, and B = b S of its output factors
// b, a section solves a2 high + a1 band + a0 low = S x with band = high + s1, low = band + s2, and moves its
// states to s1 + 2 high, s2 + 2 band. With w-transforms, a disturbance e1 of s1 adds (1 - w)/(2w) e1 to band
// = high/w, one of s2 the same to low = band/w. Solved for y = b0 low + b1 band + b2 high:
//   e1:  (1 - w)/2 [B0 a2 + B1 a2 w - B2 (a0 + a1 w)]/(a S)
//   e2:  (1 - w)/2 [B0 (a1 + a2 w) - (B1 + B2 w) a0]/(a S),
// and a disturbance of `high` is one of x. First order is the same with a single state: a1 high + a0 low = S
// x, low = high + s1, which gives (1 - w)/2 [B0 a1 - B1 a0]/(a S).
DirectSum::DirectSum(const Filter& given, double lift) : lift_(lift), lifted_(lifted_norm(given, lift)) {
  Filter filter = low_passes_first(given);
  plan_ = filter_plan<DoubleDouble>(filter);
  filter.gain = 1;
  std::vector<double> scale;  // 1/S
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    Section& s = filter.sections[i];
    const NormalizedSection<DoubleDouble>& n = plan_.sections[i];
    const DoubleDouble all = s.a[0] + s.a[1] + s.a[2];
    s.b = {n.b0 * all, n.b1 * all, n.b2 * all};
    scale.push_back((1 + 0x1p-40) / std::abs(all.hi));
  }
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    const Section& s = filter.sections[i];
    Sensitivity& t = sensitivity_.emplace_back();
    const auto bound = [&](const std::array<DoubleDouble, 3>& n) {
      return l1_bound(path(filter, i, n), lift);
    };
    t.input = bound(s.b);
    t.output =
        i + 1 < filter.sections.size() ? l1_bound(path(filter, i + 1, filter.sections[i + 1].b), lift) : 1;
    if (order_of(s) == 2) {
      t.first_state =
          scale[i] * bound(halved(s.b[0] * s.a[2] - s.b[2] * s.a[0], s.b[1] * s.a[2] - s.b[2] * s.a[1]));
      t.second_state =
          scale[i] * bound(halved(s.b[0] * s.a[1] - s.b[1] * s.a[0], s.b[0] * s.a[2] - s.b[2] * s.a[0]));
    } else {
      const DoubleDouble c = (s.b[0] * s.a[1] - s.b[1] * s.a[0]) * DoubleDouble(0.5);
      t.first_state = scale[i] * bound({c, -c, 0});
    }
  }
}

double DirectSum::tail(std::int64_t from) const {
  return lifted_ * (1 + lift_) / std::sqrt(lift_ * (2 + lift_)) *
         std::exp(-std::log1p(lift_) * (1 - 1e-14) * static_cast<double>(from)) * 1.0001;
}

/// Each rounding is charged with `unit` times its result, summed over the run and carried to the output by
/// the sensitivities. `unit` is 1.6 times the error of an operation. Of `high`, counted as input: 5
/// operations in the coefficient k1, 4 in k0, 2 products and 2 sums are at most 8 operations of |x| + |u| +
/// |v|. The rounding of band goes to the second state twice and to the output by b0 and b1; that of low to
/// the second state and to the output by b0. The output takes up to 5 of each product. The gain that the last
/// section carries is made by at most 6 operations per section.
PartialSum DirectSum::sum(std::int64_t count) const {
  constexpr double unit = RoundingErrors<DoubleDouble>::unit;
  struct Run {
    SectionState<DoubleDouble> state;
    double high = 0, first_state = 0, second_state = 0, output = 0;  // sums of sizes
  };
  std::vector<Run> runs(plan_.sections.size());
  DoubleDouble total{}, x = 1;
  double total_size = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const NormalizedSection<DoubleDouble>& s = plan_.sections[i];
      Run& r = runs[i];
      r.high += size(x);
      if (s.second) {
        r.high += size(s.k1) * size(r.state.s1) + size(s.k0) * size(r.state.s2);
        const auto u = advance<true>(s.k0, s.k1, x, r.state);
        r.first_state += size(u.band) + size(r.state.s1);
        r.second_state += 2 * size(u.band) + size(u.low) + size(r.state.s2);
        r.output +=
            size(s.b0) * (size(u.low) + size(u.band)) + size(s.b1) * size(u.band) + size(s.b2) * size(u.high);
        x = output<true>(s.b0, s.b1, s.b2, u);
      } else {
        r.high += size(s.k0) * size(r.state.s1);
        const auto u = advance<false>(s.k0, s.k1, x, r.state);
        r.first_state += size(u.low) + size(r.state.s1);
        r.output += size(s.b0) * size(u.low) + size(s.b1) * size(u.high);
        x = output<false>(s.b0, s.b1, s.b2, u);
      }
    }
    total += abs(x);
    total_size += size(total);
    x = DoubleDouble(0);
  }
  const auto rounded = static_cast<double>(total);
  double error = total_size + 6 * static_cast<double>(runs.size()) * rounded;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Sensitivity& t = sensitivity_[i];
    error += 8 * runs[i].high * t.input + runs[i].first_state * t.first_state +
             runs[i].second_state * t.second_state + 5 * runs[i].output * t.output;
  }
  return {rounded, unit * error * 1.01 + (unit + 0x1p-53) * rounded + 1e-290};
}

namespace {

constexpr double fast_modulus = 0.95;  // poles inside: direct summation needs at most a few thousand samples
constexpr std::int64_t most_direct = 4'000'000;  // samples times sections of a direct sum: about 0.4 s
constexpr std::int64_t most_runs = 3'000'000;    // blocks of sign runs times modes: at most 1 s
constexpr double narrow = 3e-13;                 // relative width of an interval that is not improved further
constexpr double negligible = 1e-18;             // truncated tail relative to the norm

Interval unbounded() { return {0, std::numeric_limits<double>::infinity()}; }

/// The intersection: both contain the norm.
Interval intersection(const Interval& x, const Interval& y) {
  return {std::max(x.lower, y.lower), std::min(x.upper, y.upper)};
}

/// value - below .. value + above, rounded outwards; unbounded when not finite.
Interval around(double value, double below, double above) {
  if (!std::isfinite(value) || !std::isfinite(below + above)) return unbounded();
  constexpr double ulp = 0x1p-52;
  return {std::max(0.0, (value - below) * (1 - ulp)), (value + above) * (1 + ulp)};
}

Interval around(const RealBall& value, double below, double above) {
  const double rad = value.rad() + std::abs(value.mid().lo);
  return around(value.mid().hi, below + rad, above + rad);
}

/// The methods to sum the impulse response of one filter.
class Summation {
 public:
  Summation(const Filter& filter, double h2)
      : filter_(filter),
        stages_(static_cast<std::int64_t>(filter.sections.size())),
        poles_(poles(filter)),
        modulus_(largest_modulus()),
        h2_(h2),
        direct_(filter, lift()) {
    if (fast() || endless()) return;
    modes_ = partial_fractions(filter, poles_.list);
  }

  /// From the H2 norm, a lower bound, and `tail(0)`, an upper one by Cauchy and Schwarz.
  Interval by_size() const { return {h2_ * (1 - 1e-12), direct_.tail(0)}; }  // 1e-12 covers the error of h2_

  /// By the direct sum, truncated at most_direct.
  Interval by_samples() const {
    const auto count = static_cast<std::int64_t>(short_enough() ? std::max(memory(), 8.0) : longest_direct());
    const PartialSum p = direct_.sum(count);
    return around(p.sum, p.error, p.error + direct_.tail(count));
  }
  /// Whether the direct sum is not truncated; false, too, where the memory is not known, as of a response
  /// whose squares are below the range of double.
  bool short_enough() const { return memory() <= longest_direct(); }

  /// By partial fractions, from the first sample where they hold.
  Interval by_modes() const {
    const auto from = static_cast<std::int64_t>(modes_.from);
    const double scale = least_norm();
    const std::int64_t step = decimation(modes_.modes, from, scale);
    const std::int64_t start = (from + step - 1) / step;
    const PartialSum head = direct_.sum(start * step);
    TailSum tail;
    for (std::int64_t offset = 0; offset < step; ++offset) {
      std::vector<Mode> part = modes_.modes;
      if (step > 1)
        for (Mode& mode : part) mode = decimated(mode, step, offset);
      tail = tail + tail_sum(std::move(part), start, scale, most_runs / step);
    }
    const double error = tail.error + head.error;
    return widened(around(tail.sum + RealBall(head.sum), error, error + tail.beyond));
  }

  /// Whether the filter's memory exceeds the range of samples.
  bool endless() const { return 100 / gap_ > static_cast<double>(latest_sample); }
  bool fast() const { return modulus_ < fast_modulus; }
  /// Whether the partial fractions are accurate; they may not be for close poles.
  bool separable() const { return Sequence(modes_.modes, Powers(modes_.modes)).accurate(); }

 private:
  /// A lower bound of the norm: ||h||_2, and ||h||_2^2 <= ||h||_1 max |h_k|.
  double least_norm() const {
    double head = 0, peak = 0;
    for (const double h : impulse_response(filter_, modes_.from)) {
      head = std::max(head, std::abs(h));
    }
    for (const Mode& mode : modes_.modes) {
      if (mode.c.size() > 1) return h2_;
      peak += (mode.pair ? 2 : 1) * largest(mode.c[0]);
    }
    return std::max(h2_, h2_ * h2_ / std::max(head, peak) * (1 - 1e-9));
  }
  /// Samples until the tail is negligible.
  double memory() const {
    return std::ceil(std::log(direct_.tail(0) / (negligible * h2_)) / std::log1p(lift()));
  }
  double longest_direct() const { return static_cast<double>(most_direct / stages_); }
  double lift() const { return std::min(1.0, 0.5 * gap_); }
  /// Also sets gap_, a lower bound of 1/|z| - 1 of the slowest pole.
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

  /// Widened by the effect of merging close poles.
  Interval widened(const Interval& i) const {
    return {i.lower * (1 - poles_.change), i.upper * (1 + poles_.change)};
  }

  Filter filter_;
  std::int64_t stages_ = 1;
  Poles poles_;
  double gap_ = 0;
  double modulus_ = 0;
  double h2_ = 0;
  DirectSum direct_;
  Modes modes_;
};

/// H(-z), with the impulse response (-1)^k h_k: 1/w for w, which maps poles near z = -1 to z = 1.
Filter reflected(Filter filter) {
  for (Section& s : filter.sections) {
    const auto order = static_cast<std::ptrdiff_t>(order_of(s));
    std::reverse(s.b.begin(), s.b.begin() + order + 1);
    std::reverse(s.a.begin(), s.a.begin() + order + 1);
  }
  return filter;
}

bool slowest_pole_in_left_half(const Filter& filter) {
  ComplexDoubleDouble slowest;
  for (const Pole& p : poles(filter).list) {
    if (norm(slowest) < norm(p.z())) slowest = p.z();
  }
  return slowest.re < DoubleDouble(0);
}

Interval of_sections(const Filter& filter) {
  const double h2 = h2_norm(filter);
  if (h2 == 0) return {0, 0};
  if (filter.sections.empty()) {
    return {1, 1};
  }
  const Summation sum(slowest_pole_in_left_half(filter) ? reflected(filter) : filter, h2);
  Interval i = sum.by_size();
  // The norm is at least |H|: quotients of double-double at z = 1 and, reflected, at z = -1.
  for (const Filter& f : {filter, reflected(filter)})
    i.lower = std::max(i.lower, std::abs(dc_gain(f)) * (1 - 1e-12));
  if (sum.endless()) return i;
  if (sum.fast()) return intersection(i, sum.by_samples());
  if (!sum.separable()) return intersection(i, sum.by_samples());
  i = intersection(i, sum.by_modes());
  // The modes of high order may cancel to more digits than their sum has.
  return i.upper - i.lower > narrow * i.upper && sum.short_enough() ? intersection(i, sum.by_samples()) : i;
}

/// Without the gain.
Interval of_taps(const Filter& filter) {
  RealBall total;
  for (const DoubleDouble& h : filter.taps) total += abs(RealBall(h));
  return around(total, 0, 0);
}

}  // namespace

Interval l1_norm(const Filter& filter) {
  Filter unit = filter;  // the gain last: with it, squares may exceed the range of double
  unit.gain = 1;
  const Interval of_unit = filter.taps.empty() ? of_sections(unit) : of_taps(unit);
  const double gain = std::abs(filter.gain.hi);
  const Interval i{gain * of_unit.lower * (1 - 0x1p-50), gain * of_unit.upper * (1 + 0x1p-50)};
  const double rounding = design_rounding(filter) * i.upper;
  return {std::max(0.0, i.lower - rounding - filter.deviation.l1), i.upper + rounding + filter.deviation.l1};
}

}  // namespace qerr
